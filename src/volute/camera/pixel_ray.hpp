// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>

#include "volute/camera/camera.hpp"

namespace volute {

/// Up to where each pixel's ray counts, as a distance from the origin of the camera's ray [m]: an
/// opaque surface. One for each pixel, row by row from the top; empty: to infinity.
using OpaqueDepth = std::span<const float>;

/// The ray through a pixel's centre, up to its opaque depth.
inline Segment pixelRay(const Camera& camera, int x, int y, OpaqueDepth opaque) {
  Segment ray = camera.ray(x + 0.5, y + 0.5);
  if (!opaque.empty())
    ray.end = opaque[static_cast<std::size_t>(y) * camera.width() + x];
  return ray;
}

}  // namespace volute
