// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <vector>

#include "volute/camera/camera.hpp"
#include "volute/tetmesh/face_planes.hpp"

namespace volute {

/// A way of looking: from an eye, or along a direction.
struct ViewOrigin {
  Vec3 eye = Vec3::Zero(), forward = Vec3::UnitX();
  bool orthographic = false;

  static ViewOrigin of(const Camera& camera) {
    const bool parallel = camera.isOrthographic();
    return {camera.eye(), parallel ? camera.forward() : Vec3(Vec3::UnitX()), parallel};
  }

  bool operator==(const ViewOrigin&) const = default;
};

/// All tets from front to back: each after those before it whose faces it shares. Where a mesh is
/// not convex, and where tets lie around each other in a circle, no such order need be right for
/// all rays: the nearest are first. Staubli et al. 2005, section 4.1, by buckets of distance.
///
/// The near half is sorted from the front while the far half is sorted from the back; what waits
/// for the other half comes between them. The order does not depend on the number of threads.
std::vector<std::int32_t> visibilityOrder(const TetMesh& mesh, const FacePlanes& faces,
                                          const ViewOrigin& view);

}  // namespace volute
