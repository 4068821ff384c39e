// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <atomic>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "volute/base/input_file.hpp"
#include "volute/base/progress.hpp"
#include "volute/base/result.hpp"
#include "volute/codec/block_codec.hpp"
#include "volute/grid/frame_source.hpp"
#include "volute/grid/grid_description.hpp"
#include "volute/grid/look_figures.hpp"
#include "volute/grid/rounding_source.hpp"

namespace volute {

/// The error over the support: the voxels that the original has active or not equal to its
/// background.
struct SupportError {
  double rms = 0;                   ///< RMS over the support / (high - low)
  double share = 0;                 ///< of the support in all voxels
  double low = 0, high = 0;         ///< the support's range over all frames
  bool robust = false;              ///< that range is ValueHistogram::robustRange()
  int worstFrame = 0;               ///< position of the frame with the greatest error
  std::array<int, 3> worstVoxel{};  ///< its place: x, y, z

  bool operator==(const SupportError&) const = default;
};

/// How much there is in each frame, so that a reader finds one that shows something.
struct FrameAmounts {
  double most = 0;                     ///< voxels of the support times the greatest value
  std::vector<std::uint8_t> shares{};  ///< of it, 0 to 255, rounded up; empty: not known

  bool operator==(const FrameAmounts&) const = default;
};

/// Properties of a .volute file besides its VolumeInfo.
struct VoluteHeader {
  int versionMajor = 0;
  int versionMinor = 0;
  int codec = 0;           ///< bit stream of the blocks; docs/format.md
  std::string writtenBy;   ///< program and version
  std::string provenance;  ///< what it was made from
  std::string targetKind;  ///< support-rms, look, rms (over all), psnr, ratio, size, max-error
  double targetValue = 0;
  double reachedRms = 0;                  ///< relative RMS over all values: RMS / (max - min)
  double reachedMaxError = 0;             ///< absolute
  double valueMin = 0, valueMax = 0;      ///< of the original
  double offset = 0;                      ///< the file has differences from it
  std::optional<SupportError> support{};  ///< none of codec 2
  FrameAmounts amounts{};
};

/// One of the grids of a file.
struct VoluteGrid {
  VolumeInfo info;  ///< x, y and z are 0 for an empty grid, which has no bounds
  VoluteHeader header;
  /// Its description in the original cache; none if it comes from elsewhere.
  std::optional<GridDescription> description{};
  bool empty = false;                 ///< in all frames
  std::uint64_t bytes = 0;            ///< of its values in the file
  std::optional<LookFigures> look{};  ///< of the original, where the file says it
};

/// Which parts of a file are present and intact.
struct Integrity {
  std::uint64_t expectedBytes = 0;
  std::uint64_t presentBytes = 0;
  std::uint64_t segments = 0;  ///< one or two levels of one block each, empty ones not counted
  std::uint64_t intactSegments = 0;
  int intactLevels = 0;    ///< levels, from the coarsest, intact in every block
  std::string firstFault;  ///< empty if everything is intact

  bool complete() const { return firstFault.empty(); }
};

class Bricks;
class KeptBytes;
struct KeptTable;

/// Reads any block, frame or region of a .volute file, and only the segments needed. Const reads
/// are thread-safe. Every byte is covered by a checksum that is verified before it is used.
class VoluteReader {
 public:
  struct Options {
    /// False: a truncated file, or reading a damaged block, is an error. True: the intact levels of
    /// a block, coarse first, are decoded and the rest is taken as zero.
    bool partial = false;
    std::uint64_t maxMemory = std::uint64_t{4} << 30;
    /// The grid to read, to which all functions below refer. Empty: 'density', else the first that
    /// is not empty; of a file without such a grid() one that is none of its grids(), and is empty.
    std::string grid{};
    /// Values are read as differences from the grid's offset(), where it has one: float32 does not
    /// hold their sums as well as the file does. Else, and with kOfRounded those of a grid of a
    /// cache that were float32, they are the sums, rounded.
    Offsets differences = Offsets::kNone;
  };

  [[nodiscard]] static Result<VoluteReader> open(const std::filesystem::path& path,
                                                 const Options& options);

  /// What is open already.
  [[nodiscard]] static Result<VoluteReader> open(InputFile file, const Options& options);

  [[nodiscard]] static Result<VoluteReader> open(const std::filesystem::path& path) {
    return open(path, Options{});
  }

  const VolumeInfo& info() const;
  const VoluteHeader& header() const;

  /// The offset to add to the values read: VoluteHeader::offset where they are differences, else 0.
  double offset() const;

  const BlockGrid& blocks() const;

  /// All grids of the file, in its order.
  const std::vector<VoluteGrid>& grids() const;

  /// The grid that is read.
  const VoluteGrid& grid() const;

  /// Metadata of the files of a cache.
  const FrameMetadata& fileMetadata() const;

  /// Grids of a cache that the file holds as their bytes.
  const KeptTable& kept() const;

  /// One of them in a frame; null where it has none there. The reader must outlive it.
  /// @param grid  in kept().grids
  [[nodiscard]] std::unique_ptr<KeptBytes> keptBytes(std::size_t grid, int frame) const;

  /// Checks every segment of the grid.
  Integrity verify() const;

  /// Adds the intact parts of the kept grids.
  void verifyKept(Integrity& integrity) const;

  /// The same; kCancelled if `progress` requests it.
  [[nodiscard]] Result<Integrity> verify(Progress& progress) const;

  /// Fills `values` with block `block` at full resolution, shape = blocks().extents(block) x
  /// channels, (t, z, y, x, c) in C order. `levels` < blocks().levels(block) decodes only that many
  /// levels from the coarsest on (a preview); 1 is the mean of the block, for which most files need
  /// nothing but their index.
  /// @param wanted  frames of the block; what `values` hold in others is not said
  [[nodiscard]] Status readBlock(std::size_t block, std::span<float> values, int levels = 99,
                                 FrameSpan wanted = {}) const;

  /// [begin, end) on the axes t, z, y, x. Decodes the blocks it intersects, in parallel.
  [[nodiscard]] Status readBox(const BlockGrid::Index4& begin, const BlockGrid::Index4& end,
                               std::span<float> values, int levels = 99) const;

  /// The region of one frame: [begin, end) in voxels on the axes z, y, x, shape (z, y, x, c).
  [[nodiscard]] Status readRegion(int frame, const std::array<int, 3>& begin,
                                  const std::array<int, 3>& end, std::span<float> values,
                                  int levels = 99) const;

  /// Row `row` of blocks: their frames, shape (t, z, y, x, c).
  [[nodiscard]] Status readRow(int row, std::span<float> values, int levels = 99) const;

  /// The frames first <= frame < end of one row of blocks, with their topology. Decodes the blocks
  /// that are not empty, in parallel.
  /// @param bricks  one for each frame
  [[nodiscard]] Status readBricks(int first, int end, std::span<Bricks> bricks) const;

  /// Bytes that the bricks of a row take, at most.
  std::uint64_t brickBytes(int row) const;

  /// The background: the value of voxels that the file does not store, per channel.
  std::array<float, 3> background() const;

  /// Whether the file keeps topology: which voxels are active, tiles and the background.
  bool hasTopology() const;

  /// Numbers of the blocks that hold something, and how many there are. The first reads the whole
  /// index.
  [[nodiscard]] Result<std::vector<std::uint64_t>> occupied() const;
  std::uint64_t occupiedCount() const;

  /// A short description of how a block is coded. Reads its first tier.
  [[nodiscard]] Result<std::string> describeBlock(std::size_t block) const;

  /// Bytes that the values of a block take in the file.
  [[nodiscard]] Result<std::uint64_t> storedBytes(std::size_t block) const;

  std::uint64_t maxMemory() const;

  /// Bytes read and blocks decoded since open, for `extract`'s report.
  std::uint64_t bytesRead() const;
  std::uint64_t blocksDecoded() const;

  /// Requests and bytes that the head and the index have taken since and with open.
  std::uint64_t indexRequests() const;
  std::uint64_t indexBytes() const;

  VoluteReader(VoluteReader&&) noexcept;
  VoluteReader& operator=(VoluteReader&&) noexcept;
  ~VoluteReader();

 private:
  struct Impl;
  explicit VoluteReader(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// A .volute file as a source of frames; keeps the decoded row of blocks that holds the current
/// frame, if that fits in the reader's maxMemory.
std::unique_ptr<FrameSource> frameSource(std::shared_ptr<const VoluteReader> reader);

}  // namespace volute
