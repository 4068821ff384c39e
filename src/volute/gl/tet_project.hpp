// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>

#include "volute/tetmesh/visibility_order.hpp"

namespace volute {

/// How a tet's outline looks (Staubli et al. 2005, Figure 4).
enum class TetClass : std::uint8_t {
  kTriangle,  ///< class 1: one vertex is seen before or behind the face across
  kQuad,      ///< class 2: two edges cross
  kAround,    ///< the eye is inside
};

/// A tet's outline as it is seen from an eye: a convex polygon.
struct ProjectedTet {
  TetClass shape = TetClass::kAround;
  int sides = 0;  ///< of the outline; 0 for kAround
  /// The tet's four vertices: the outline's in turn, then what is left.
  std::array<std::int8_t, 4> corners{0, 1, 2, 3};
};

/// From the eye's barycentric coordinates, which are the four determinants of the vectors from the
/// eye to three vertices, over their sum; of an orthographic camera those of the point at infinity
/// behind it, -slope . forward, which sum to 0. The class is the number of their positive signs:
/// 1 or 3 (odd), 2 (even), 4. Zero counts as positive: what is seen edge-on covers nothing.
ProjectedTet projectTet(const std::array<double, 4>& eyeShares);

/// Barycentric coordinates of the eye in a tet, as projectTet() takes them.
std::array<double, 4> eyeShares(const TetMesh& mesh, std::int32_t tet, const ViewOrigin& view);

}  // namespace volute
