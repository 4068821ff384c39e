// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/grid/bricks.hpp"
#include "volute/grid/frame_source.hpp"
#include "volute/grid/grid_description.hpp"
#include "volute/grid/kept_bytes.hpp"

namespace volute {

/// How to write a volume.
struct SinkOptions {
  bool half = false;      ///< OpenVDB: store values as 16-bit floats
  double offset = 0;      ///< values are differences from it, and numbers are written as float64
  bool orVolute = false;  ///< the caller writes .volute files: an error names them too
};

/// A sink according to `output`: OUT.npy (float32, (t, z, y, x) or (t, z, y, x, 3)), or "-" for the
/// same on standard output; a pattern such as smoke_%04d.vdb or smoke_%04d.vti, one file per frame
/// with its number in the name (a plain name suffices for one frame); OUT.pvd, which writes
/// OUT_0001.vti, ... and a list of them with their times; OUT.nc or OUT.h5, which is netCDF-4 in
/// HDF5 either way. The grid or array is called info.name. No
/// file appears before finish(). kInvalidArgument, "output: ...", for other names.
[[nodiscard]] Result<std::unique_ptr<FrameSink>> createSink(const std::filesystem::path& output,
                                                            const VolumeInfo& info,
                                                            const SinkOptions& options = {});

/// Whether createSink() knows the format of this name; its error where it does not.
[[nodiscard]] Status checkFormat(const std::filesystem::path& output, bool orVolute);

/// One of the grids of a cache to be written.
struct GridTarget {
  VolumeInfo info;              ///< x is 0 for an empty grid
  GridDescription description;  ///< of the frames in `info`, and of its first voxel
  double offset = 0;            ///< values are differences from it
};

/// One that goes into the files as its bytes.
struct KeptTarget {
  std::size_t place = 0;  ///< how many of the other grids stand before it
  /// Null where the frame at this position has none.
  std::function<Result<std::unique_ptr<KeptBytes>>(int position)> open;
};

/// Writes all grids of a cache, frame by frame, in order.
class CacheSink {
 public:
  virtual ~CacheSink() = default;

  /// What is in each grid, as FrameSource::readBricks gives it; nothing of empty grids.
  [[nodiscard]] virtual Status writeFrame(std::span<const Bricks> grids) = 0;

  /// To be called after the last frame; without it, no file appears.
  [[nodiscard]] virtual Status finish() = 0;
};

/// A sink for .vdb files, by a pattern such as cache_%04d.vdb (a plain name suffices for one
/// frame), each with all `grids` and those that are `kept`. There is one of either kind.
/// @param fileMetadata  metadata of each file
/// @param frames  numbers of the frames; null: as those of the first grid
[[nodiscard]] Result<std::unique_ptr<CacheSink>> createCacheSink(
    const std::filesystem::path& output, std::vector<GridTarget> grids, FrameMetadata fileMetadata,
    std::vector<KeptTarget> kept = {}, const VolumeInfo* frames = nullptr);

}  // namespace volute
