// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "volute/camera/camera.hpp"
#include "volute/grid/traversal.hpp"
#include "volute/grid/volume_info.hpp"
#include "volute/image/image.hpp"
#include "volute/math/box.hpp"

namespace volute {

/// What one calibrated camera saw of one frame.
struct TomographyView {
  std::string name;  ///< for messages
  Camera camera;     ///< pixel (x, y) is centred at camera.ray(x + 0.5, y + 0.5)
  Image radiance;    ///< measured minus background, linear RGB, as wide and high as the camera;
                     ///< finite; negative values are kept (clamping them costs 1.1 dB)
  std::vector<float> weight{};  ///< (height, width), 0..1; 0 = saturated, masked or invalid; empty:
                                ///< 1 everywhere
  /// (height, width), bit c: channel c is saturated, its radiance what is measured or more; empty:
  /// none. The weight of such pixels is 0; kApg takes what they tell all the same.
  std::vector<std::uint8_t> atLeast{};
  /// `radiance` holds optical depths, `weight` how much light is left, as OpticalDepths has them:
  /// noise is the larger the darker a pixel is.
  bool opticalDepth = false;
  std::vector<std::uint8_t> silhouette{};  ///< (height, width), not 0 where the medium is seen,
                                           ///< before dilation; empty: by threshold
  double sightError = 0;  ///< how far off its sights are, root mean square [pixels]: silhouettes
                          ///< are wider by twice as much
  Image background{};     ///< what was subtracted, RGB; empty: nothing, or it was not asked for
  bool grey = false;  ///< `radiance` is the mean of the channels, for its camera knows no colours,
                      ///< and others do

  bool counts(std::size_t pixel) const { return weight.empty() || weight[pixel] != 0; }

  bool isSaturated(std::size_t pixel) const { return !atLeast.empty() && atLeast[pixel] != 0; }
};

/// Where the unknown volume lies.
struct VolumeGeometry {
  Box3 bounds;                      ///< outer voxel faces [m]
  std::array<int, 3> resolution{};  ///< voxels on x, y, z

  std::size_t voxels() const {
    return static_cast<std::size_t>(resolution[0]) * resolution[1] * resolution[2];
  }

  Vec3 voxelSize() const {
    return bounds.size().cwiseQuotient(Vec3(resolution[0], resolution[1], resolution[2]));
  }
};

}  // namespace volute
