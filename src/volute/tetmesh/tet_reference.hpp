// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>

#include "volute/camera/pixel_ray.hpp"
#include "volute/tetmesh/tet_medium.hpp"

namespace volute {

/// Optical depth of each pixel, one for each, by clipping every tet near its ray, in double; slow
/// and simple: what the fast paths are measured by.
void referenceDepth(const TetMedium& medium, const Camera& camera, OpaqueDepth opaque,
                    std::span<double> depth);

/// Light and transmittance of each pixel, four for each, the same way.
void referenceColor(const TetMedium& medium, const Camera& camera, OpaqueDepth opaque,
                    std::span<double> rgbt);

}  // namespace volute
