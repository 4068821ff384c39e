// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/smoke_walls.hpp"

#include <Eigen/Geometry>
#include <limits>
#include <numbers>

#include "volute/base/parallel.hpp"

namespace volute {
namespace {

/// A face of the boundary, anticlockwise from inside.
struct WallFace {
  std::array<std::int32_t, 3> vertices;
  Vec3 inwards;  ///< unit normal
};

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
      walls.push_back({{a, b, c}, normal.normalized()});
  }
  return walls;
}

/// The corners' shares of a point in a triangle.
Vec3 sharesIn(const WallFace& wall, std::span<const Vec3> points, const Vec3& point) {
  const Vec3& a = points[wall.vertices[0]];
  const Vec3 u = points[wall.vertices[1]] - a, v = points[wall.vertices[2]] - a, w = point - a;
  const Vec3 normal = u.cross(v);
  const double area = normal.squaredNorm();
  const double second = w.cross(v).dot(normal) / area, third = u.cross(w).dot(normal) / area;
  return Vec3(1 - second - third, second, third).cwiseMax(0);
}

Rgb lightOn(const WallFace& wall, const Vec3& point, const SmokeState& smoke,
            const SceneLights& lights) {
  const Vec3 shares = sharesIn(wall, smoke.locator->mesh().vertices(), point);
  Rgb light = lights.ambient;
  for (std::size_t l = 0; l < lights.lamps.size(); ++l) {
    double share = 0;
    for (int k = 0; k < 3; ++k) share += shares[k] * smoke.lampShares[l][wall.vertices[k]];
    const double cosine = wall.inwards.dot(lights.lamps[l].towards(point).direction);
    if (cosine > 0)
      light += share * cosine / std::numbers::pi * lights.lamps[l].irradiance(point);
  }
  return light;
}

Result<TriangleScene> sceneOf(std::span<const WallFace> walls, std::span<const Vec3> points) {
  std::vector<Triangle> triangles(walls.size());
  for (std::size_t i = 0; i < walls.size(); ++i) {
    for (int k = 0; k < 3; ++k) triangles[i].corners[k] = points[walls[i].vertices[k]];
  }
  return TriangleScene::build(std::move(triangles));
}

}  // namespace

Result<SurfaceView> lookAtWalls(const Camera& camera, const SmokeState& smoke,
                                const SceneLights& lights, const Rgb& color) {
  const TetMesh& mesh = smoke.locator->mesh();
  const auto walls = wallsFacing(camera, mesh);
  VOLUTE_ASSIGN(const auto scene, sceneOf(walls, mesh.vertices()));
  const auto width = static_cast<std::size_t>(camera.width());
  SurfaceView view{std::vector<float>(width * static_cast<std::size_t>(camera.height()),
                                      std::numeric_limits<float>::infinity()),
                   Image(camera.width(), camera.height(), 3)};
  parallelFor(static_cast<std::size_t>(camera.height()), [&](std::size_t y) {
    std::vector<Segment> rays;
    for (std::size_t x = 0; x < width; ++x)
      rays.push_back(camera.ray(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5));
    std::vector<Hit> hits(width);
    scene.nearest(rays, hits);
    for (std::size_t x = 0; x < width; ++x) {
      if (!hits[x].found())
        continue;
      view.depth[y * width + x] = static_cast<float>(hits[x].distance);
      const Rgb seen =
          color * lightOn(walls[hits[x].triangle], rays[x].at(hits[x].distance), smoke, lights);
      for (int c = 0; c < 3; ++c)
        view.color.at(static_cast<int>(x), static_cast<int>(y), c) = static_cast<float>(seen[c]);
    }
  });
  return view;
}

}  // namespace volute
