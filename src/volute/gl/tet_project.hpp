// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>

#include "volute/gl/tet_sort.hpp"

namespace volute {

/// How a tet's outline looks (Staubli et al. 2005, Figure 4).
enum class TetClass : std::uint8_t {
  kTriangle,  ///< class 1: one vertex is seen before or behind the face across; a fan of three
  kQuad,      ///< class 2: two edges cross; a fan of four
  kAround,    ///< the eye is inside: all four faces, from within
};

/// A tet as it is seen from an eye: a fan of triangles around the thick vertex, the only one where
/// the ray has a length in the tet. On each triangle of the fan front and back are planes.
struct ProjectedTet {
  TetClass shape = TetClass::kTriangle;
  /// The thick vertex's front and back as shares of the four vertices; each sums to 1. Both lie on
  /// one ray. For kAround the front is the eye, and there is no back.
  std::array<double, 4> front{}, back{};
  int triangles = 0;
  /// Corners of each triangle; kThick is the thick vertex.
  std::array<std::array<std::int8_t, 3>, 4> corners{};

  static constexpr std::int8_t kThick = 4;
};

/// From the eye's barycentric coordinates, which are the four determinants of the vectors from the
/// eye to three vertices, over their sum; of an orthographic camera those of the point at infinity
/// behind it, -slope . forward, which sum to 0. The class is the number of their positive signs:
/// 1 or 3 (odd), 2 (even), 4. Zero counts as positive: triangles that are seen edge-on cover
/// nothing.
ProjectedTet projectTet(const std::array<double, 4>& eyeShares);

/// What projectTet() asks for.
std::array<double, 4> eyeShares(const TetMesh& mesh, std::int32_t tet, const TetEye& eye);

}  // namespace volute
