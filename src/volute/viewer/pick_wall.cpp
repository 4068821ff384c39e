// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/pick_wall.hpp"

#include "volute/render/surfaces.hpp"

namespace volute {

namespace {

/// Where the ray meets it [m]; nothing: it does not, or sees the side that is not there.
std::optional<double> meets(const GlQuad& quad, const Segment& ray) {
  const Vec3 normal = quad.down.cross(quad.right);  // towards who sees `right` go to the right
  const double slope = normal.dot(ray.direction);
  if (slope == 0 || (slope > 0 && !quad.bothSides))
    return std::nullopt;
  const double distance = normal.dot(quad.corner - ray.origin) / slope;
  const Vec3 on = ray.at(distance) - quad.corner;
  const double across = on.dot(quad.right) / quad.right.squaredNorm();
  const double along = on.dot(quad.down) / quad.down.squaredNorm();
  const bool inside = across >= 0 && across <= 1 && along >= 0 && along <= 1;
  return inside && distance >= ray.begin && distance <= ray.end ? std::optional(distance)
                                                                : std::nullopt;
}

}  // namespace

std::optional<WallPlace> pickWall(const ViewScene& scene, const Segment& ray) {
  Hit hit;
  if (!scene.geometry.empty())
    scene.geometry.nearest({&ray, 1}, {&hit, 1});
  double nearest = hit.distance;
  Vec3 normal = -ray.direction;
  bool found = hit.found();
  if (found)
    normal = facing(scene.geometry, ray, hit);
  for (const auto& medium : scene.now) {
    const auto wall = medium->wallOn(ray);
    if (!wall || !(wall->distance < nearest))
      continue;
    nearest = wall->distance, found = true;
    normal = wall->normal;
  }
  for (const GlQuad& quad : scene.quads) {
    const auto distance = meets(quad, ray);
    if (!distance || !(*distance < nearest))
      continue;
    nearest = *distance, found = true;
    normal = quad.down.cross(quad.right).normalized();
    if (normal.dot(ray.direction) > 0)
      normal = -normal;
  }
  if (!found)
    return std::nullopt;
  return WallPlace{ray.at(nearest), normal};
}

}  // namespace volute
