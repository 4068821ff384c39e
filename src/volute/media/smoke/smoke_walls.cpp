// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/smoke/smoke_walls.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <numbers>

#include "volute/base/parallel.hpp"

namespace volute {
namespace {

/// A face of the boundary, anticlockwise from inside.
struct WallFace {
  std::array<std::int32_t, 3> vertices;
  std::int32_t tet;  ///< behind it
  Vec3 inwards;      ///< unit normal
};

/// Shares of a lamp's light that are alike.
constexpr float kAlike = 0.01F;

std::vector<WallFace> wallsFacing(const Camera& camera, const TetMesh& mesh) {
  std::vector<WallFace> walls;
  const auto points = mesh.vertices();
  for (const std::int32_t f : mesh.boundary()) {
    const TetFace& face = mesh.faces()[f];
    auto [a, b, c] = face.vertices;
    Vec3 normal = (points[b] - points[a]).cross(points[c] - points[a]);
    const Vec3& inner = points[mesh.tets()[face.first / 4][face.first % 4]];
    if (normal.dot(inner - points[a]) < 0) {
      std::swap(b, c);
      normal = -normal;
    }
    const Vec3 toEye =
        camera.isOrthographic() ? Vec3(-camera.forward()) : Vec3(camera.eye() - points[a]);
    if (normal.dot(toEye) > 0)
      walls.push_back({{a, b, c}, face.first / 4, normal.normalized()});
  }
  return walls;
}

/// The lamps before the walls of a mesh.
class WallLight {
 public:
  WallLight(const SmokeState& smoke, const SceneLights& lights, const Blocks& blocks)
      : smoke_(smoke), lights_(lights), blocks_(blocks) {
    for (const Lamp& lamp : lights.lamps)
      inside_.push_back(lamp.kind == Lamp::Kind::kSpot && smoke.locator->find(lamp.position) >= 0);
  }

  /// What a point of a wall reflects if it reflects all.
  Rgb on(const WallFace& wall, const Vec3& point) const {
    const Vec3 shares = cornerShares(wall.vertices, smoke_.locator->mesh().vertices(), point);
    Rgb light = lights_.ambient;
    for (std::size_t l = 0; l < lights_.lamps.size(); ++l) {
      const Segment way = lights_.lamps[l].towards(point);
      const double cosine = wall.inwards.dot(way.direction);
      const Rgb arriving = lights_.lamps[l].irradiance(point);
      if (cosine > 0 && (arriving > 0).any())
        light += shareOf(l, wall, way, shares) * cosine / std::numbers::pi * arriving;
    }
    return light;
  }

 private:
  double shareOf(std::size_t lamp, const WallFace& wall, const Segment& way,
                 const Vec3& shares) const {
    const auto& known = smoke_.lampShares[lamp];
    const float corners[3] = {known[wall.vertices[0]], known[wall.vertices[1]],
                              known[wall.vertices[2]]};
    const auto [least, most] = std::ranges::minmax(corners);
    if (most - least <= kAlike)
      return shares[0] * corners[0] + shares[1] * corners[1] + shares[2] * corners[2];
    const double share =
        lampShareAt(*smoke_.locator, smoke_.extinction, way, wall.tet, inside_[lamp]);
    std::uint8_t blocked = 0;
    if (share > 0 && blocks_)
      blocks_({&way, 1}, {&blocked, 1});
    return blocked ? 0 : share;
  }

  const SmokeState& smoke_;
  const SceneLights& lights_;
  const Blocks& blocks_;
  std::vector<char> inside_;  // of each lamp: it is in the mesh
};

Result<TriangleScene> sceneOf(std::span<const WallFace> walls, std::span<const Vec3> points) {
  std::vector<Triangle> triangles(walls.size());
  for (std::size_t i = 0; i < walls.size(); ++i) {
    for (int k = 0; k < 3; ++k) triangles[i].corners[k] = points[walls[i].vertices[k]];
  }
  return TriangleScene::build(std::move(triangles));
}

constexpr double kGap = 1e-6;  ///< [m] between tets that counts as outside

/// Where a ray leaves a mesh for the first time: the tet, and how far that is [m].
struct MeshExit {
  std::int32_t tet = -1;
  double distance = std::numeric_limits<double>::infinity();
};

MeshExit exitOf(const TetLocator& locator, const Segment& ray) {
  std::vector<TetCrossing> crossings;
  locator.crossings(ray, crossings);
  for (std::size_t i = 0; i < crossings.size(); ++i) {
    const bool last = i + 1 == crossings.size();
    if (last || crossings[i + 1].begin > crossings[i].end + kGap)
      return {crossings[i].tet, crossings[i].end};
  }
  return {};
}

/// Inwards, of the face through which a ray leaves a tet.
Vec3 normalBehind(const TetMesh& mesh, std::int32_t tet, const Segment& ray) {
  const auto points = mesh.vertices();
  const Tet& corners = mesh.tets()[static_cast<std::size_t>(tet)];
  double nearest = std::numeric_limits<double>::infinity();
  Vec3 normal = -ray.direction;
  for (int k = 0; k < 4; ++k) {
    const Vec3& a = points[corners[(k + 1) & 3]];
    const Vec3& b = points[corners[(k + 2) & 3]];
    const Vec3& c = points[corners[(k + 3) & 3]];
    Vec3 across = (b - a).cross(c - a);
    if (across.dot(points[corners[k]] - a) < 0)
      across = -across;
    const double towards = across.dot(ray.direction);
    if (!(towards < 0))
      continue;
    const double distance = across.dot(a - ray.origin) / towards;
    if (distance < nearest)
      nearest = distance, normal = across.normalized();
  }
  return normal;
}

}  // namespace

std::optional<WallHit> wallLeft(const TetLocator& locator, const Segment& ray) {
  const MeshExit exit = exitOf(locator, ray);
  if (exit.tet < 0)
    return std::nullopt;
  return WallHit{exit.distance, normalBehind(locator.mesh(), exit.tet, ray)};
}

Vec3 cornerShares(const std::array<std::int32_t, 3>& corners, std::span<const Vec3> points,
                  const Vec3& point) {
  const Vec3& a = points[corners[0]];
  const Vec3 u = points[corners[1]] - a, v = points[corners[2]] - a, w = point - a;
  const Vec3 normal = u.cross(v);
  const double area = normal.squaredNorm();
  const double second = w.cross(v).dot(normal) / area, third = u.cross(w).dot(normal) / area;
  return Vec3(1 - second - third, second, third).cwiseMax(0);
}

Result<SurfaceView> lookAtWalls(const Camera& camera, const SmokeState& smoke,
                                const SceneLights& lights, const Rgb& color, const Blocks& blocks,
                                std::span<const std::uint8_t> only) {
  const TetMesh& mesh = smoke.locator->mesh();
  const auto walls = wallsFacing(camera, mesh);
  VOLUTE_ASSIGN(const auto scene, sceneOf(walls, mesh.vertices()));
  const WallLight light(smoke, lights, blocks);
  const auto width = static_cast<std::size_t>(camera.width());
  SurfaceView view{std::vector<float>(width * static_cast<std::size_t>(camera.height()),
                                      std::numeric_limits<float>::infinity()),
                   Image(camera.width(), camera.height(), 3)};
  parallelFor(static_cast<std::size_t>(camera.height()), [&](std::size_t y) {
    std::vector<Segment> rays;
    std::vector<std::size_t> columns;
    for (std::size_t x = 0; x < width; ++x) {
      if (!only.empty() && !only[y * width + x])
        continue;
      columns.push_back(x);
      rays.push_back(camera.ray(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5));
    }
    std::vector<Hit> hits(rays.size());
    scene.nearest(rays, hits);
    for (std::size_t i = 0; i < hits.size(); ++i) {
      const std::size_t x = columns[i];
      if (!hits[i].found())
        continue;
      view.depth[y * width + x] = static_cast<float>(hits[i].distance);
      const Rgb seen = color * light.on(walls[hits[i].triangle], rays[i].at(hits[i].distance));
      for (int c = 0; c < 3; ++c)
        view.color.at(static_cast<int>(x), static_cast<int>(y), c) = static_cast<float>(seen[c]);
    }
  });
  return view;
}

}  // namespace volute
