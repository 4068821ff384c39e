// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>

#include "volute/camera/camera.hpp"
#include "volute/tetmesh/tet_medium.hpp"

namespace volute {

/// Up to where each pixel's ray counts, as a distance from the origin of the camera's ray [m]: an
/// opaque surface. One for each pixel, row by row from the top; empty: to infinity.
using OpaqueDepth = std::span<const float>;

/// The ray through a pixel's centre, up to its opaque depth.
Segment pixelRay(const Camera& camera, int x, int y, OpaqueDepth opaque);

/// Optical depth of each pixel, one for each, by clipping every tet near its ray, in double; slow
/// and simple: what the fast paths are measured by.
void referenceDepth(const TetMedium& medium, const Camera& camera, OpaqueDepth opaque,
                    std::span<double> depth);

/// Light and transmittance of each pixel, four for each, the same way.
void referenceColor(const TetMedium& medium, const Camera& camera, OpaqueDepth opaque,
                    std::span<double> rgbt);

}  // namespace volute
