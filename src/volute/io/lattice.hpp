// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/grid/bricks.hpp"
#include "volute/grid/frustum_sampling.hpp"
#include "volute/grid/grid_description.hpp"
#include "volute/grid/grid_matrix.hpp"
#include "volute/grid/index_box.hpp"
#include "volute/grid/kept_bytes.hpp"
#include "volute/grid/vector_kind.hpp"
#include "volute/grid/volume_info.hpp"

namespace volute {

/// Names of metadata of our own, which no file of another program gets: the type of a grid's values
/// in a frame where that is not GridDescription::type, and the frame's number as it stands in the
/// name of its file ("-002") where frameText() would write another.
inline constexpr const char* kTypeEntry = "volute:type";
inline constexpr const char* kNumberEntry = "volute:number";

/// The entry of that name; null: there is none.
inline const GridMetadata* findEntry(const MetadataList& list, std::string_view name) {
  const auto found = std::ranges::find(list, name, &GridMetadata::name);
  return found == list.end() ? nullptr : &*found;
}

/// One file's grid on its lattice of voxels, without the values. Trivially copyable: it crosses
/// from the process that reads the file to ours as bytes.
struct LatticeFrame {
  static constexpr std::size_t kMaxName = 255, kMaxWriter = 23, kMaxUnit = 31;

  char grid[kMaxName + 1] = {};    ///< the name, ends in 0
  char others[kMaxName + 1] = {};  ///< the names of grids that were not chosen, as people read them
  char leftOut[kMaxName + 1] = {};    ///< what the file has that is never read, as people read it
  int channels = 1;                   ///< 1 or 3
  IndexBox box;                       ///< where the file has values; may be empty
  std::array<double, 3> voxelSize{};  ///< [m]
  std::array<double, 3> origin{};     ///< centre of the voxel with index 0 [m]
  /// It is turned, mirrored or sheared: `matrix` is from index to world, and the two above are in a
  /// space of its own, spaceOf() that.
  bool turned = false;
  GridMatrix matrix{};
  double time = std::numeric_limits<double>::quiet_NaN();  ///< [s]; NaN when not stated
  bool levelSet = false;
  char up = 0;  ///< the axis that points upwards for what wrote the file; 0: unknown
  char writer[kMaxWriter + 1] = {};  ///< that program; empty: unknown, or the file states the axis
  char unit[kMaxUnit + 1] = {};      ///< of the values; empty: unknown
  char gridClass[kMaxWriter + 1] = {};  ///< "fog volume"; empty: unknown
  bool bricks = false;                  ///< LatticeReader::readBricks() gives its topology
  bool rounded = false;                 ///< a float may be another number than one of the file
  std::uint64_t memory = 0;             ///< [bytes] that its bricks take, about; 0: unknown
  std::uint64_t hidden = 0;             ///< voxels that the file marks as none, which are 0
  VectorKind vectors{};                 ///< of three channels
};

/// What a file says of one of its grids, and what is in it. Trivially copyable, as LatticeFrame.
struct GridFacts {
  static constexpr std::size_t kMaxName = 127, kMaxType = 31, kMaxProblem = 127;

  char name[kMaxName + 1] = {};
  char type[kMaxType + 1] = {};       ///< of a value: "float", "vec3s"
  char gridClass[kMaxType + 1] = {};  ///< "fog volume", "staggered", "level set"; empty: unknown
  IndexBox box;                       ///< of voxels that are not empty
  std::array<double, 3> voxelSize{};  ///< [m]; zeros where voxels are not along the axes
  std::uint64_t voxels = 0;           ///< that are not empty
  std::uint64_t memory = 0;           ///< [bytes] in OpenVDB's tree
  double least = 0, most = 0;  ///< of all values, of all channels; NaN where they are no numbers
  bool half = false;           ///< stored as 16-bit floats
  bool frustum = false;        ///< its voxels widen with the distance, as no matrix says
  bool readable = false;       ///< LatticeReader::read() takes it
  char problem[kMaxProblem + 1] =
      {};  ///< why nothing is known of its voxels; empty: they were read
};

/// What a file of a cache says of one of its grids. Trivially copyable, as LatticeFrame.
struct GridTraits {
  static constexpr std::size_t kMaxText = 63, kMaxProblem = 127;

  char type[kMaxText + 1] = {};  ///< as in GridDescription, and so are the others
  char gridClass[kMaxText + 1] = {};
  char map[kMaxText + 1] = {};
  char problem[kMaxProblem + 1] = {};  ///< why it is no volume, "of type int32"; empty: it is one
  std::array<double, 3> background{};
  std::uint64_t voxels = 0;
  std::uint64_t memory = 0;  ///< [bytes]; of what is no volume those in the file, 0: unknown
  bool half = false;
};

/// A grid of one file of a cache.
struct LatticeGrid {
  LatticeFrame frame;
  GridTraits traits;
  MetadataList metadata{};  ///< but for what the rest says
};

/// All grids of one file, in its order.
struct LatticeCache {
  std::vector<LatticeGrid> grids{};
  MetadataList metadata{};  ///< of the file
};

/// What a library that knows a volume format does with one file of it. Used inside a child process
/// (ReaderProcess), because damaged files may crash such libraries.
class LatticeReader {
 public:
  virtual ~LatticeReader() = default;

  /// The grid named `grid`, or the one that chooseGrid finds when it is empty, `usual` of several.
  /// Without `needBox` the box may be left empty where it would cost reading the values.
  [[nodiscard]] virtual Result<LatticeFrame> describe(const std::filesystem::path& file,
                                                      const std::string& grid,
                                                      const std::string& usual, bool needBox) = 0;

  /// All grids of a file, in its order; holds about `limit` bytes of values at a time. kUnsupported
  /// where the format has one.
  [[nodiscard]] virtual Result<std::vector<GridFacts>> list(const std::filesystem::path& file,
                                                            std::uint64_t limit) {
    (void)limit;
    return fail(ErrorCode::kUnsupported, "{}: a format without a list of grids", file.string());
  }

  /// The same as of a cache that is to be given back, without the values. kUnsupported where the
  /// format has no caches.
  [[nodiscard]] virtual Result<LatticeCache> describeAll(const std::filesystem::path& file) {
    return fail(ErrorCode::kUnsupported, "{}: a format without caches", file.string());
  }

  /// The grid at a position in describeAll() as a whole file of its own, whose bytes a
  /// LatticeWriter takes as they are. kTooLarge where it takes more than `limit` bytes.
  [[nodiscard]] virtual Result<std::string> keep(const std::filesystem::path& file,
                                                 std::size_t grid, std::uint64_t limit) {
    (void)grid, (void)limit;
    return fail(ErrorCode::kUnsupported, "{}: a format without caches", file.string());
  }

  /// Fills `values`, shape (z, y, x, c) over `box`, some layers of `whole`, and touches little more
  /// than that; voxels that the file does not have get its background value. Values outside `whole`
  /// are cut off when `crop` is true, else they are an error where its first layers are read.
  /// @param rounding  set to the largest difference between a number of the file and its float
  [[nodiscard]] virtual Status read(const std::filesystem::path& file, const std::string& grid,
                                    const IndexBox& whole, const IndexBox& box, bool crop,
                                    std::span<float> values, double& rounding) = 0;

  /// Whether readBricks() gives the topology that files have.
  virtual bool hasBricks() const { return false; }

  /// How grids with a frustum are read from now on; null: they are refused.
  virtual void sampleFrusta(const FrustumSampling* how) { (void)how; }

  /// Values are read as differences from `offset` from now on.
  virtual void takeOffset(double offset) { (void)offset; }

  /// What is in `box`, some layers of `whole`, with its topology; voxel (0, 0, 0) is the lattice's.
  /// Leaves and tiles across the box's border are whole. Errors as read().
  [[nodiscard]] virtual Result<Bricks> readBricks(const std::filesystem::path& file,
                                                  const std::string& grid, const IndexBox& whole,
                                                  const IndexBox& box, bool crop,
                                                  double& rounding) {
    (void)grid, (void)whole, (void)box, (void)crop, (void)rounding;
    return fail(ErrorCode::kUnsupported, "{}: a format without topology", file.string());
  }

  /// The background of the grid that readBricks() gave last, where it is NaN or infinite: the
  /// bricks have 0 instead. Else 0.
  virtual double lostBackground() const { return 0; }
};

/// How a frame is written.
struct LatticeWriterOptions {
  bool half = false;  ///< OpenVDB: values as 16-bit floats
  double offset = 0;  ///< values are differences from it; numbers are written as doubles
  bool zip =
      false;  ///< OpenVDB: zlib, slower and smaller than Blosc; the grid's class is unknown then
};

/// A grid of a frame of a cache.
struct GridFrame {
  const VolumeInfo* info = nullptr;  ///< one with x = 0 is empty
  const GridDescription* description = nullptr;
  int frame = 0;                   ///< its position
  const Bricks* bricks = nullptr;  ///< of the volume in `info`
  KeptBytes* kept = nullptr;       ///< instead of all that: what LatticeReader::keep() gave
  double offset = 0;               ///< values are differences from it
};

/// Writes one frame to one file.
class LatticeWriter {
 public:
  virtual ~LatticeWriter() = default;

  /// `values` have shape (z, y, x, c). Writes to `temporary`; messages name `target`.
  [[nodiscard]] virtual Status write(const std::filesystem::path& temporary,
                                     const std::filesystem::path& target, const VolumeInfo& info,
                                     int frame, std::span<const float> values) = 0;

  /// Whether frames are written by writeBricks(), which keeps their topology.
  virtual bool takesBricks() const { return false; }

  [[nodiscard]] virtual Status writeBricks(const std::filesystem::path& temporary,
                                           const std::filesystem::path& target,
                                           const VolumeInfo& info, int frame,
                                           const Bricks& bricks) {
    (void)temporary, (void)info, (void)frame, (void)bricks;
    return fail(ErrorCode::kUnsupported, "{}: a format without topology", target.string());
  }

  /// The same for all grids of a cache, as their descriptions say. Nothing in those is trusted.
  /// @param metadata  of the file; null: none
  [[nodiscard]] virtual Status writeGrids(const std::filesystem::path& temporary,
                                          const std::filesystem::path& target,
                                          std::span<const GridFrame> grids,
                                          const MetadataList* metadata) {
    (void)temporary, (void)grids, (void)metadata;
    return fail(ErrorCode::kUnsupported, "{}: a format without caches", target.string());
  }
};

/// A file of a time series and when it is shown.
struct TimedFile {
  double time = 0;  ///< [s]
  std::filesystem::path path;
};

/// What a plug-in for a volume format offers. The plug-in exports a function that returns its
/// table.
struct LatticePlugin {
  std::unique_ptr<LatticeReader> (*makeReader)();
  std::unique_ptr<LatticeWriter> (*makeWriter)(const LatticeWriterOptions& options);
  /// The files that a collection (.pvd) names; null where the format has no collections.
  Result<std::vector<TimedFile>> (*readCollection)(const std::filesystem::path& file);
};

}  // namespace volute
