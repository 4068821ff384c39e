// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/surface_corners.hpp"

#include <algorithm>
#include <cmath>
#include <queue>

namespace volute {
namespace {

constexpr double kInwards = 1e-3;  ///< how far a corner's light is found from it, to the middle

struct Piece {
  Triangle triangle;
  double longest = 0;  ///< edge [m]
  int edge = 0;        ///< from this corner to the next

  bool operator<(const Piece& other) const { return longest < other.longest; }
};

Piece pieceOf(const Triangle& triangle) {
  Piece piece{triangle};
  for (int i = 0; i < 3; ++i) {
    const double length = (triangle.corners[(i + 1) % 3] - triangle.corners[i]).norm();
    if (length > piece.longest)
      piece.longest = length, piece.edge = i;
  }
  return piece;
}

/// The longest edge is halved first, until there are so many.
std::vector<Triangle> divided(std::span<const Triangle> triangles, std::size_t most,
                              double smallest) {
  std::priority_queue<Piece> pieces;
  for (const Triangle& triangle : triangles) pieces.push(pieceOf(triangle));
  while (!pieces.empty() && pieces.size() < most && pieces.top().longest > smallest) {
    const Piece piece = pieces.top();
    pieces.pop();
    const int a = piece.edge, b = (a + 1) % 3;
    const Vec3 middle = 0.5 * (piece.triangle.corners[a] + piece.triangle.corners[b]);
    Triangle first = piece.triangle, second = piece.triangle;
    first.corners[b] = middle, second.corners[a] = middle;
    pieces.push(pieceOf(first));
    pieces.push(pieceOf(second));
  }
  std::vector<Triangle> out;
  for (; !pieces.empty(); pieces.pop()) out.push_back(pieces.top().triangle);
  return out;
}

}  // namespace

ViewSurfaces surfaceCorners(const SurfaceScene& scene, std::size_t most) {
  constexpr double kPieces = 60;  // across the scene
  const double smallest = scene.geometry.bounds().size().norm() / kPieces;
  const auto triangles = divided(scene.geometry.triangles(), most, smallest);
  const double reach = 1e-4 * scene.geometry.bounds().size().norm();
  std::vector<Segment> looks;
  ViewSurfaces surfaces;
  for (const Triangle& triangle : triangles) {
    const Vec3 across = triangle.normal();
    if (!(across.norm() > 0))
      continue;
    const Vec3 middle = (triangle.corners[0] + triangle.corners[1] + triangle.corners[2]) / 3;
    for (const double side : {1.0, -1.0}) {
      const Vec3 normal = side * across.normalized();
      for (int i = 0; i < 3; ++i) {
        const Vec3& corner = triangle.corners[side > 0 ? i : 2 - i];
        for (int axis = 0; axis < 3; ++axis)
          surfaces.corners.push_back(static_cast<float>(corner[axis]));
        const Vec3 at = corner + kInwards * (middle - corner);
        looks.push_back({at + reach * normal, -normal, 0, 2 * reach});
      }
    }
  }
  for (const SurfacePoint& point : lookAtSurfaces(scene, looks)) {
    for (int c = 0; c < 3; ++c) surfaces.colors.push_back(static_cast<float>(point.radiance[c]));
  }
  return surfaces;
}

}  // namespace volute
