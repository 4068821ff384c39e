// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/gl_snapshot.hpp"

#include <map>
#include <typeinfo>
#include <utility>

#include "volute/gl/gl_kinds.hpp"
#include "volute/gl/gl_part.hpp"

namespace volute {
namespace {

std::map<std::type_index, GlWallsOf>& wallTable() {
  static std::map<std::type_index, GlWallsOf> table;
  return table;
}

}  // namespace

GlPartTable<MediumAt, GlSnapshotOptions>& glMedia() {
  static GlPartTable<MediumAt, GlSnapshotOptions> table;
  return table;
}

void registerGlWalls(std::type_index type, GlWallsOf walls) {
  wallTable().insert_or_assign(type, std::move(walls));
}

Result<GlScene> glSceneOf(const Snapshot& snapshot, const GlSnapshotOptions& options) {
  registerUsualGlMedia();
  GlScene scene{.shade = snapshot.fixedGeometry};
  for (const auto& medium : snapshot.media) {
    VOLUTE_ASSIGN(auto parts, glMedia().partsOf(*medium, options));
    for (auto& part : parts) scene.parts.push_back(std::move(part));
  }
  return options.natural ? scene.scaled(1 / snapshot.law.factor()) : scene;
}

Result<GlWalls> glWallsOf(const Snapshot& snapshot, std::size_t medium) {
  registerUsualGlMedia();
  const MediumAt& of = *snapshot.media[medium];
  const auto found = wallTable().find(std::type_index(typeid(of)));
  if (found == wallTable().end())
    return fail(ErrorCode::kUnsupported, "OpenGL does not draw the walls of this kind of medium");
  return found->second(of, snapshot.geometry);
}

}  // namespace volute
