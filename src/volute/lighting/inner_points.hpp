// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>
#include <vector>

#include "volute/tetmesh/tet_mesh.hpp"

namespace volute {

/// How far the walls of a mesh may be from the surfaces of another file that show them [m]: by the
/// digits of the other file, and by those of coordinates as float.
double wallRounding(const TetMesh& mesh);

/// The vertices of a mesh, those on its boundary moved so far inside of its faces; where these turn
/// away from each other, as far as one way goes.
std::vector<Vec3> innerVertices(const TetMesh& mesh, double distance);

/// A point of a tet, moved towards its centre until it is so far from the faces, or halfway.
Vec3 innerPoint(const TetMesh& mesh, std::int32_t tet, const Vec3& point, double distance);

/// Where a mesh takes the light that others leave it. Its walls are shown by other surfaces, which
/// are before or behind it by rounding: what arrives at vertices in walls is what arrives on the
/// side of their cells.
class InnerSide {
 public:
  /// @param surfaces  whether there are any; else at the vertices themselves
  InnerSide(const TetMesh& mesh, bool surfaces);
  InnerSide(const InnerSide&) = delete;

  /// One for each of the mesh; must not outlive it.
  std::span<const Vec3> vertices() const { return vertices_; }

  double rounding() const { return rounding_; }  ///< wallRounding(); 0 without surfaces

  double lift() const { return kLift * rounding_; }  ///< how far inside [m]

  static constexpr double kLift = 3;  ///< roundings: also where its ways begin one later

 private:
  double rounding_ = 0;
  std::vector<Vec3> inner_;
  std::span<const Vec3> vertices_;
};

}  // namespace volute
