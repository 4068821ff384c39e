// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string_view>

#include "volute/base/result.hpp"
#include "volute/codec/block_grid.hpp"
#include "volute/grid/sequence.hpp"

namespace volute::bench {

/// A way to put a sequence into files and to take it out again: Volute and its peers behind one
/// interface. Peers hold scalars, so each channel is a volume of its own.
class FileCodec {
 public:
  /// What `setting` of encode() means.
  enum class Setting {
    kRelativeRms,  ///< the error that the file keeps by itself
    kTolerance,    ///< an absolute tolerance per value, which somebody has to search
  };

  virtual ~FileCodec() = default;

  virtual Setting setting() const = 0;

  /// Writes files into the empty `folder`. Decoded values times the returned number are the data's:
  /// 1 but for zfp, which knows only powers of two as tolerances.
  [[nodiscard]] virtual Result<float> encode(const Sequence& sequence, double setting,
                                             const std::filesystem::path& folder) const = 0;

  /// Fills `values`, shape (t, z, y, x, c), from the files in `folder`.
  [[nodiscard]] virtual Status decode(const VolumeInfo& info, const std::filesystem::path& folder,
                                      std::span<float> values) const = 0;

  /// Fills `values` with [begin, end) on the axes t, z, y, x. As it is here: of all that is
  /// decoded, for a codec that knows no less.
  [[nodiscard]] virtual Status decodePart(const VolumeInfo& info,
                                          const std::filesystem::path& folder,
                                          const BlockGrid::Index4& begin,
                                          const BlockGrid::Index4& end,
                                          std::span<float> values) const;
};

/// Of frames first <= t < end of all values, shape (t, z, y, x, c), what lies in [begin, end).
void copyPart(const VolumeInfo& info, std::span<const float> frames, int first,
              const BlockGrid::Index4& begin, const BlockGrid::Index4& end,
              std::span<float> values);

using MadeCodec = Result<std::unique_ptr<FileCodec>>;

struct FileCodecEntry {
  std::string_view name;
  MadeCodec (*make)();  ///< kUnsupported when this build lacks the library
};

/// A peer whose sources are in a folder.
struct SourceCodecEntry {
  std::string_view name;   ///< and that of the folder
  std::string_view build;  ///< arguments for the compiler, which runs in that folder
  bool byFrames = false;   ///< it takes three axes at most
};

std::span<const SourceCodecEntry> sourceCodecs();

/// Builds it with the system's compiler. kUnsupported, with what the compiler said, where that
/// fails.
/// @param sources  the folder that has the peer's
/// @param scratch  where the library is put
[[nodiscard]] MadeCodec makeSourceCodec(const SourceCodecEntry& entry,
                                        const std::filesystem::path& sources,
                                        const std::filesystem::path& scratch);

/// Volute first, then its peers.
std::span<const FileCodecEntry> fileCodecs();

MadeCodec makeVoluteCodec();
MadeCodec makeZfp4dCodec();    ///< accuracy mode, the whole sequence as one array
MadeCodec makeZfp3dCodec();    ///< accuracy mode, a frame at a time
MadeCodec makeNanoVdbCodec();  ///< FpN grids with AbsDiff as the oracle, zip on disk
MadeCodec makeVdbCodec();      ///< half floats, sparse within the tolerance, zip, a file a frame

}  // namespace volute::bench
