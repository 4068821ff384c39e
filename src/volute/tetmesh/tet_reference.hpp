// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>

#include "volute/camera/camera.hpp"
#include "volute/medium/medium.hpp"
#include "volute/tetmesh/tet_mesh.hpp"

namespace volute {

/// Which part of each pixel's ray counts: up to an opaque surface, distance along the ray from the
/// camera's ray origin [m], one for each pixel, row by row from the top. Empty: to infinity.
using OpaqueDepth = std::span<const float>;

/// Optical depth of each pixel by meeting every tet with the ray through the pixel's centre, in
/// double. Slow and simple: what the fast paths are measured by. depth: one for each pixel.
void referenceDepth(const TetMesh& mesh, std::span<const float> extinction, const Camera& camera,
                    OpaqueDepth opaque, std::span<double> depth);

}  // namespace volute
