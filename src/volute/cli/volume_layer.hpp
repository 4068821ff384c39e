// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <string>

#include "volute/cli/volume_input.hpp"
#include "volute/grid/brick_slice.hpp"
#include "volute/grid/voxel_medium.hpp"

namespace volute::cli {

/// How a volume looks: what one unit of its values emits and absorbs.
struct Appearance {
  double emission = 1;         ///< radiance per metre per unit
  double extinction = 0;       ///< 1/m per unit
  std::optional<Basis> basis;  ///< instead of the file's
};

/// A volume file that is shown: gives the medium of any of its frames.
class VolumeLayer {
 public:
  [[nodiscard]] static Result<VolumeLayer> open(const std::string& path,
                                                const InputOptions& options,
                                                const Appearance& appearance, Context& context);

  const VolumeInfo& info() const { return info_; }

  /// The frame at a position as bricks. The last one is kept.
  [[nodiscard]] Result<std::shared_ptr<const BrickSlice>> sliceAt(int position);

  [[nodiscard]] Result<VoxelMedium> mediumAt(int position);

  /// Null unless it is a .volute file.
  const VoluteReader* reader() const { return input_.reader.get(); }

 private:
  VolumeLayer(VolumeInput input, const Appearance& appearance);

  std::string path_;
  VolumeInput input_;
  Appearance appearance_;
  VolumeInfo info_;
  std::vector<float> frame_;
  int position_ = -1;
  std::shared_ptr<const BrickSlice> slice_;
};

}  // namespace volute::cli
