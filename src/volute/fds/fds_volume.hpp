// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <optional>

#include "volute/fds/fds_case.hpp"
#include "volute/grid/frame_source.hpp"

namespace volute {

/// The extinction of a case [1/m] as voxels, at its stored times: all meshes together with voxels
/// of the finest cell size, or one mesh. A voxel has the value at its centre; obstructions and
/// places outside all meshes are 0.
class FdsVolume final : public FrameSource {
 public:
  struct Options {
    FdsOptions read;             ///< `volume` is set
    std::optional<int> mesh;     ///< from 0; none: all together
    std::optional<Box3> bounds;  ///< [m] the region to read, rounded to whole voxels
  };

  /// kTooLarge if a frame needs more than read.maxMemory.
  [[nodiscard]] static Result<std::unique_ptr<FdsVolume>> open(const std::filesystem::path& path,
                                                               Options options);

  const VolumeInfo& info() const override { return info_; }

  [[nodiscard]] Status readFrame(int index, std::span<float> values) override;

  const FdsCase& fdsCase() const { return case_; }

 private:
  explicit FdsVolume(FdsCase opened) : case_(std::move(opened)) {}

  Status placeVoxels(const Options& options);

  FdsCase case_;
  VolumeInfo info_;
};

/// The size of the finest cells on each axis [m].
Vec3 finestCell(const FdsGrid& grid);

}  // namespace volute
