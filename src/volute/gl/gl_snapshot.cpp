// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/gl_snapshot.hpp"

#include <map>
#include <typeinfo>
#include <utility>

#include "volute/gl/gl_kinds.hpp"
#include "volute/gl/gl_part.hpp"
#include "volute/scene/clip.hpp"

namespace volute {
namespace {

std::map<std::type_index, GlWallsOf>& wallTable() {
  static std::map<std::type_index, GlWallsOf> table;
  return table;
}

std::vector<GlCut> cutsOf(const SceneClip& clip) {
  std::vector<GlCut> cuts;
  for (const ClipPlane& plane : clip.planes) cuts.push_back({plane.point, plane.normal});
  for (const Box3& box : clip.boxes) {
    for (int axis = 0; axis < 3; ++axis) {
      cuts.push_back({box.min, -Vec3::Unit(axis)});
      cuts.push_back({box.max, Vec3::Unit(axis)});
    }
  }
  return cuts;
}

}  // namespace

GlPartTable<MediumSnapshot, GlSnapshotOptions>& glMedia() {
  static GlPartTable<MediumSnapshot, GlSnapshotOptions> table;
  return table;
}

void registerGlWalls(std::type_index type, GlWallsOf walls) {
  wallTable().insert_or_assign(type, std::move(walls));
}

Result<GlScene> glSceneOf(const SceneSnapshot& snapshot, const GlSnapshotOptions& options) {
  registerUsualGlMedia();
  GlScene scene{.shade = snapshot.fixedGeometry};
  for (const auto& medium : snapshot.media) {
    if (const SceneClip* clip = clipOf(*medium); clip && scene.cuts.empty())
      scene.cuts = cutsOf(*clip);  // the same for all
    VOLUTE_ASSIGN(auto parts, glMedia().partsOf(unclipped(*medium), options));
    for (auto& part : parts) scene.parts.push_back(std::move(part));
  }
  return options.natural ? scene.scaled(1 / snapshot.law.factor()) : scene;
}

Result<GlWalls> glWallsOf(const SceneSnapshot& snapshot, std::size_t medium) {
  registerUsualGlMedia();
  const MediumSnapshot& of = unclipped(*snapshot.media[medium]);
  const auto found = wallTable().find(std::type_index(typeid(of)));
  if (found == wallTable().end())
    return fail(ErrorCode::kUnsupported, "OpenGL does not draw the walls of this kind of medium");
  return found->second(of, snapshot.geometry);
}

}  // namespace volute
