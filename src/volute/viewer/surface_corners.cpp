// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/surface_corners.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numbers>
#include <queue>

#include "volute/media/smoke/smoke_medium.hpp"
#include "volute/media/smoke/smoke_walls.hpp"

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

/// Two, at the middle of its longest edge.
std::array<Triangle, 2> halved(const Piece& piece) {
  const int a = piece.edge, b = (a + 1) % 3;
  const Vec3 middle = 0.5 * (piece.triangle.corners[a] + piece.triangle.corners[b]);
  std::array halves{piece.triangle, piece.triangle};
  halves[0].corners[b] = middle, halves[1].corners[a] = middle;
  return halves;
}

/// The longest edge is halved first, until there are so many.
std::vector<Triangle> divided(std::span<const Triangle> triangles, std::size_t most,
                              double smallest) {
  std::priority_queue<Piece> pieces;
  for (const Triangle& triangle : triangles) pieces.push(pieceOf(triangle));
  while (!pieces.empty() && pieces.size() < most && pieces.top().longest > smallest) {
    const Piece piece = pieces.top();
    pieces.pop();
    for (const Triangle& half : halved(piece)) pieces.push(pieceOf(half));
  }
  std::vector<Triangle> out;
  for (; !pieces.empty(); pieces.pop()) out.push_back(pieces.top().triangle);
  return out;
}

/// The boundary's faces, anticlockwise from inside; materials are places in boundary().
std::vector<Triangle> wallsOf(const TetMesh& mesh) {
  std::vector<Triangle> walls;
  const auto points = mesh.vertices();
  for (std::size_t i = 0; i < mesh.boundary().size(); ++i) {
    const TetFace& face = mesh.faces()[mesh.boundary()[i]];
    Triangle wall{{}, static_cast<std::uint32_t>(i)};
    for (int k = 0; k < 3; ++k) wall.corners[k] = points[face.vertices[k]];
    const Vec3& inner = points[mesh.tets()[face.first / 4][face.first % 4]];
    if (wall.normal().dot(inner - wall.corners[0]) < 0)
      std::swap(wall.corners[1], wall.corners[2]);
    walls.push_back(wall);
  }
  return walls;
}

/// What reaches a point of a wall, as radiance if the wall reflects all of it.
Rgb lightOn(const SmokeState& smoke, const SceneLights& lights, const TetFace& face,
            const Vec3& normal, const Vec3& point) {
  const Vec3 shares = cornerShares(face.vertices, smoke.locator->mesh().vertices(), point);
  Rgb light = lights.ambient;
  for (std::size_t l = 0; l < lights.lamps.size(); ++l) {
    const double cosine = normal.dot(lights.lamps[l].towards(point).direction);
    if (!(cosine > 0))
      continue;
    double share = 0;
    for (int k = 0; k < 3; ++k) share += shares[k] * smoke.lampShares[l][face.vertices[k]];
    light += share * cosine / std::numbers::pi * lights.lamps[l].irradiance(point);
  }
  return light;
}

constexpr double kPieces = 60;    ///< across the scene
constexpr int kHalvings = 6;      ///< more, where light is uneven: edges of shadows and cones
constexpr double kUneven = 0.04;  ///< between corners, of the brightest

/// A triangle with the light that its corners send back, of the front and of the back.
struct LitPiece {
  Piece piece;
  std::array<Rgb, 3> light[2];

  double unevenness() const {
    double most = 0;
    for (const auto& side : light) {
      for (int i = 0; i < 3; ++i)
        most = std::max(most, (side[i] - side[(i + 1) % 3]).abs().maxCoeff());
    }
    return most;
  }
};

std::vector<LitPiece> lit(const SurfaceScene& scene, std::span<const Triangle> triangles) {
  double reach = 1e-4 * scene.geometry.bounds().size().norm();
  for (const CurvedPart& part : scene.geometry.curved())
    reach = std::max(reach, part.surface->roughness());
  std::vector<LitPiece> pieces;
  std::vector<Segment> looks;
  for (const Triangle& triangle : triangles) {
    const Vec3 across = triangle.normal();
    if (!(across.norm() > 0))
      continue;
    LitPiece& dark = pieces.emplace_back();
    dark.piece = pieceOf(triangle);
    for (auto& side : dark.light) side.fill(Rgb::Zero());
    const Vec3 middle = (triangle.corners[0] + triangle.corners[1] + triangle.corners[2]) / 3;
    for (const double side : {1.0, -1.0}) {
      const Vec3 normal = side * across.normalized();
      for (const Vec3& corner : triangle.corners) {
        const Vec3 at = corner + kInwards * (middle - corner);
        looks.push_back({at + reach * normal, -normal, 0, 2 * reach});
      }
    }
  }
  auto point = lookAtSurfaces(scene, looks);
  auto next = point.begin();
  for (LitPiece& piece : pieces) {
    for (auto& side : piece.light) {
      for (Rgb& corner : side) corner = (next++)->radiance;
    }
  }
  return pieces;
}

/// Those whose corners differ much are halved, the most uneven ones first, while there may be more.
/// False if there were none.
bool refine(const SurfaceScene& scene, std::vector<LitPiece>& pieces, std::size_t most) {
  double brightest = 0;
  for (const LitPiece& piece : pieces) {
    for (const auto& side : piece.light) {
      for (const Rgb& light : side) brightest = std::max(brightest, light.maxCoeff());
    }
  }
  auto uneven = std::partition(pieces.begin(), pieces.end(), [&](const LitPiece& piece) {
    return !(piece.unevenness() > kUneven * brightest);
  });
  const auto may = static_cast<std::ptrdiff_t>(most > pieces.size() ? most - pieces.size() : 0);
  if (pieces.end() - uneven > may) {
    std::nth_element(uneven, pieces.end() - may, pieces.end(),
                     [](const LitPiece& a, const LitPiece& b) {
                       return a.unevenness() * a.piece.longest < b.unevenness() * b.piece.longest;
                     });
    uneven = pieces.end() - may;
  }
  std::vector<Triangle> halves;
  for (auto piece = uneven; piece != pieces.end(); ++piece) {
    for (const Triangle& half : halved(piece->piece)) halves.push_back(half);
  }
  pieces.erase(uneven, pieces.end());
  std::ranges::move(lit(scene, halves), std::back_inserter(pieces));
  return !halves.empty();
}

}  // namespace

GlSurfaces surfaceCorners(const SurfaceScene& scene, std::size_t most) {
  const double smallest = scene.geometry.bounds().size().norm() / kPieces;
  auto pieces = lit(scene, divided(scene.geometry.triangles(), most, smallest));
  const std::size_t atMost = std::max(2 * most, pieces.size() + most);
  for (int i = 0; i < kHalvings && refine(scene, pieces, atMost); ++i) {
  }
  GlSurfaces surfaces;
  for (const LitPiece& piece : pieces) {
    for (int side = 0; side < 2; ++side) {
      for (int i = 0; i < 3; ++i) {
        const int corner = side == 0 ? i : 2 - i;
        for (int k = 0; k < 3; ++k) {
          surfaces.corners.push_back(static_cast<float>(piece.piece.triangle.corners[corner][k]));
          surfaces.colors.push_back(static_cast<float>(piece.light[side][corner][k]));
        }
      }
    }
  }
  return surfaces;
}

GlSurfaces wallCorners(const MediumSnapshot& medium, std::size_t most) {
  const auto& shown = dynamic_cast<const SmokeSnapshot&>(medium);
  const SmokeState& smoke = shown.state();
  const SceneLights& lights = shown.lights();
  const Rgb& color = *shown.walls();
  const TetMesh& mesh = smoke.locator->mesh();
  GlSurfaces surfaces;
  for (const Triangle& piece :
       divided(wallsOf(mesh), most, mesh.bounds().size().norm() / kPieces)) {
    const Vec3 across = piece.normal();
    if (!(across.norm() > 0))
      continue;
    const TetFace& face = mesh.faces()[mesh.boundary()[piece.material]];
    for (const Vec3& corner : piece.corners) {
      const Rgb light = color * lightOn(smoke, lights, face, across.normalized(), corner);
      for (int axis = 0; axis < 3; ++axis) {
        surfaces.corners.push_back(static_cast<float>(corner[axis]));
        surfaces.colors.push_back(static_cast<float>(light[axis]));
      }
    }
  }
  return surfaces;
}

}  // namespace volute
