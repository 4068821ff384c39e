// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "volute/camera/camera.hpp"
#include "volute/image/image.hpp"

namespace volute {

/// A flat picture on a wall that people look for: an exit sign. Opaque, seen from its front alone.
struct Sign {
  std::string name;
  Vec3 position = Vec3::Zero();  ///< of its middle [m]
  Vec3 normal = Vec3::UnitX();   ///< towards those who read it; any length > 0
  double width = 0.6;            ///< [m]
  double height = 0.3;           ///< [m]
  double c = 3;   ///< at which optical depth it is no longer seen: 8 where it emits light, else 3
  Image picture;  ///< linear RGB radiance, at least one pixel
  std::string pictureFile{};  ///< where that is from; empty: exitPicture()

  /// The directions of the picture's rows and columns, of unit length: right and down of one who
  /// reads it. Signs stand upright along z; those that lie have their top towards +y.
  Vec3 right() const;
  Vec3 down() const;
};

/// Where a sign is what a pixel's ray meets first.
struct SignPixel {
  std::int32_t pixel = 0;  ///< row by row from the top
  std::int32_t sign = 0;
  float distance = 0;  ///< along the ray [m]
  float radiance[3] = {};
};

/// The pixels whose centre's ray meets a sign before `opaqueDepth` (empty: nothing is in the way),
/// in ascending order. Pictures are averaged over the pixel, inside the sign's borders.
std::vector<SignPixel> signPixels(const Camera& camera, std::span<const Sign> signs,
                                  std::span<const float> opaqueDepth);

/// A green sign that says EXIT, for those that have no picture.
Image exitPicture();

}  // namespace volute
