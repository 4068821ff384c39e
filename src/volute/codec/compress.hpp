// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "volute/base/progress.hpp"
#include "volute/base/result.hpp"
#include "volute/base/team.hpp"
#include "volute/codec/effort.hpp"
#include "volute/codec/volute_reader.hpp"
#include "volute/codec/wavelet_codec.hpp"
#include "volute/grid/frame_source.hpp"

namespace volute {

/// The target of a compression.
struct ErrorTarget {
  enum class Kind {
    /// RMS over the support / its range <= value. The support is the set of voxels that are active
    /// in the source or differ from its background; its range is that of all frames, without the
    /// few values apart that ValueHistogram::robustRange() leaves out.
    kRms,
    kRmsOverAll,  ///< RMS over all voxels and channels / (max - min of the whole original) <= value
    kPsnr,        ///< [dB]; relative RMS over all voxels <= 10^(-value / 20)
    kRatio,       ///< raw float32 bytes / file bytes >= value
    kSize,        ///< file bytes <= value
    kMaxError,    ///< |decoded - original| <= value at every voxel
    /// As kRms, of values that are coded the finer the fainter they are: for pictures, in which an
    /// error shows by its share of what is around it.
    kLook,
  };
  Kind kind = Kind::kLook;
  double value = kLookRms;
  /// Of an RMS over the support: whether what is the same all over counts, which takes accuracy
  /// from the rest. Else `value` is met by what differs from place to place,
  /// ValueHistogram::varied().
  bool even = false;

  /// Of kLook: what pictures do not show, measured by tools/default_quality.py.
  static constexpr double kLookRms = 7e-4;

  bool isOverSupport() const { return kind == Kind::kRms || kind == Kind::kLook; }
};

/// "draft": smaller, errors are seen in pictures that are made bright. "look": a picture of it and
/// one of the original look the same. "measure": numbers as near as those of 16-bit floats.
struct QualityWord {
  std::string_view word;
  ErrorTarget target;
};

inline constexpr std::array<QualityWord, 3> kQualityWords{
    {{"draft", {ErrorTarget::Kind::kLook, 4e-3}},
     {"look", {ErrorTarget::Kind::kLook, ErrorTarget::kLookRms}},
     {"measure", {ErrorTarget::Kind::kRms, 1e-4}}}};

/// The usual access, which determines the frames per block: kFrame, single frames (4); kFilm, all
/// frames in order (16). kAny: as few as cost almost no bytes.
enum class Access { kAny, kFrame, kFilm };

struct CompressOptions {
  ErrorTarget target;
  Access access = Access::kAny;
  std::string wavelet = "auto";   ///< auto, haar, cdf53 or cdf97: allowed for blocks
  std::optional<BlockMode> mode;  ///< one mode for all blocks, for experiments
  int effort = kDefaultEffort;    ///< 1, the fastest, to 9, the smallest files
  std::string provenance;         ///< kept in the file
  /// The absolute error of the source relative to its own original; the file states the sums, which
  /// bound the errors relative to that original.
  double sourceRms = 0;
  double sourceMaxError = 0;
  /// The values are 16-bit floats and will be rounded to such again: the target holds after that
  /// rounding, too. The file states the errors before it.
  bool halves = false;
  /// The values will be rounded to float32, offset and all: the target holds after that rounding as
  /// before it. So it is anyway of values that are all such.
  bool floats = false;
  std::uint64_t maxMemory = std::uint64_t{4} << 30;
  /// A folder for finished units, shared by all ranks: an interrupted run continues from them, with
  /// any number of ranks, and gives the same bytes. Removed at the end. Empty: none.
  std::filesystem::path work{};
  /// The name of the file in errors, where the target is a temporary file; empty: the target.
  std::string name{};
};

/// A frame whose own values span less than a tenth of the range that errors are relative to.
struct FaintFrame {
  int position = 0;
  double range = 0;        ///< of its support
  double relativeRms = 0;  ///< RMS over its support / that range
};

struct CompressReport {
  std::uint64_t rawBytes = 0;
  std::uint64_t fileBytes = 0;
  double relativeRms = 0;  ///< over all voxels; measured on the written data
  double maxError = 0;     ///< absolute
  SupportError support{};
  std::vector<FaintFrame> faintFrames{};
  double valueMin = 0, valueMax = 0;
  std::size_t blocks = 0;
  int blockFrames = 0;  ///< of a block
  double seconds = 0;
};

/// Compresses `source` into the .volute file `target`. Holds a row of blocks (up to 16 frames) in
/// memory, or, if that is too much and the source can be read by layers, some layers of it, for any
/// number of frames. NaN and Inf are refused with frame and voxel. The bytes are the same for any
/// number of threads and ranks. Rank 0 writes; the others need only the source, and space for their
/// share in the target's folder or in that for temporary files. Values far from 0 keep the
/// exactness of doubles, and floats theirs, where settleOffset(source) was called before.
/// Collective.
[[nodiscard]] Result<CompressReport> compress(FrameSource& source,
                                              const std::filesystem::path& target,
                                              const CompressOptions& options, Progress& progress,
                                              Team& team);

/// Compresses in this process alone, without a team.
[[nodiscard]] Result<CompressReport> compress(FrameSource& source,
                                              const std::filesystem::path& target,
                                              const CompressOptions& options, Progress& progress);

}  // namespace volute
