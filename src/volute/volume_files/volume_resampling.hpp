// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>
#include <string>

#include "volute/base/team.hpp"
#include "volute/grid/resample.hpp"
#include "volute/io/reading.hpp"
#include "volute/report/report.hpp"
#include "volute/volume_files/volume_input.hpp"

namespace volute {

/// What a volume is resampled to. What is not said is as in the volume: voxels as long as its own
/// along each axis, around all that it takes in any frame, along the axes of the world.
struct ResampleRequest {
  std::string fields{};  ///< grids of a file with several; empty: all
  bool partial = false;  ///< a damaged .volute is read as far as it is intact
  FrameRange frames{};
  StatedInfo stated{};
  std::optional<Vec3> voxelSize{};     ///< [m]
  std::optional<Box3> bounds{};        ///< outer faces of the new voxels [m]
  std::optional<GridMatrix> matrix{};  ///< from the index of a new voxel to the world [m]
  std::string like{};                  ///< a volume whose first frame's voxels they are
  Basis basis = Basis::kTrilinear;     ///< of the old voxels
  double rms = 1e-3;                   ///< of a .volute
};

/// Reads grids of a volume of any kind and writes them on other voxels: a .volute, or what
/// createSink() takes. Frustums of OpenVDB and voxels that are turned, sheared or moving are
/// sampled where they are.
[[nodiscard]] Result<Report> resampleVolume(const std::string& path, const std::string& target,
                                            const ResampleRequest& request, Reading& reading,
                                            Team& team);

}  // namespace volute
