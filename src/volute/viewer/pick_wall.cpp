// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/pick_wall.hpp"

#include "volute/render/surfaces.hpp"

namespace volute {

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
  if (!found)
    return std::nullopt;
  return WallPlace{ray.at(nearest), normal};
}

}  // namespace volute
