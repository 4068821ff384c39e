// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
#include <typeindex>
#include <vector>

#include "volute/gl/gl_part_table.hpp"
#include "volute/gl/gl_scene.hpp"
#include "volute/gl/gl_smoke.hpp"
#include "volute/scene/scene_snapshot.hpp"

namespace volute {

/// How a snapshot becomes what OpenGL draws.
struct GlSnapshotOptions {
  bool natural = false;  ///< extinctions as they are, whatever the picture's law
  bool tables = false;   ///< what is alone in a picture may be drawn by a table for its eye
  GlSmokeMethod smokeMethod = GlSmokeMethod::kAuto;
};

using GlParts = std::vector<std::shared_ptr<const GlPart>>;

/// What OpenGL makes of a medium at one time, with extinctions as it has them: times the factor
/// of the picture's law. A row for each type that it draws.
GlPartTable<MediumSnapshot, GlSnapshotOptions>& glMedia();

/// Of one that hasWalls(), with what else stands in the light.
using GlWallsOf = std::function<GlWalls(const MediumSnapshot& medium, const TriangleScene& others)>;

/// Adds the walls that media of a type have.
void registerGlWalls(std::type_index type, GlWallsOf walls);

/// All media of a snapshot. kUnsupported where one is of no type in the table: the CPU draws it.
[[nodiscard]] Result<GlScene> glSceneOf(const SceneSnapshot& snapshot,
                                        const GlSnapshotOptions& options);

/// The walls of a medium that has some, as light meets them: natural.
[[nodiscard]] Result<GlWalls> glWallsOf(const SceneSnapshot& snapshot, std::size_t medium);

}  // namespace volute
