// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/pick_wall.hpp"

#include <Eigen/Geometry>
#include <limits>

namespace volute {
namespace {

constexpr double kGap = 1e-6;  ///< [m] between tets that counts as outside

/// Where a ray leaves a mesh for the first time: the tet, and how far that is [m].
struct Exit {
  std::int32_t tet = -1;
  double distance = std::numeric_limits<double>::infinity();
};

Exit exitOf(const TetLocator& locator, const Segment& ray) {
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

std::optional<WallPlace> pickWall(const ViewScene& scene, const Segment& ray) {
  Hit hit;
  if (!scene.geometry.empty())
    scene.geometry.nearest({&ray, 1}, {&hit, 1});
  double nearest = hit.distance;
  Vec3 normal = -ray.direction;
  bool found = hit.found();
  if (found) {
    normal = scene.geometry.triangles()[hit.triangle].normal().normalized();
    if (normal.dot(ray.direction) > 0)
      normal = -normal;
  }
  for (const auto& locator : scene.meshes) {
    const Exit exit = exitOf(*locator, ray);
    if (exit.tet < 0 || !(exit.distance < nearest))
      continue;
    nearest = exit.distance, found = true;
    normal = normalBehind(locator->mesh(), exit.tet, ray);
  }
  if (!found)
    return std::nullopt;
  return WallPlace{ray.at(nearest), normal};
}

}  // namespace volute
