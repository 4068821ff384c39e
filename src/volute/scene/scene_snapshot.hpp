// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "volute/geometry/triangle_scene.hpp"
#include "volute/media/medium_snapshot.hpp"
#include "volute/media/scene_lights.hpp"
#include "volute/optics/visibility.hpp"
#include "volute/render/sign.hpp"

namespace volute {

/// A scene at one time, with everything that pictures of it need. Immutable: threads may render
/// pictures while others request the next time.
struct SceneSnapshot {
  double time = 0;                                           ///< [s], of the scene
  PictureLaw law;                                            ///< law for everything except signs
  std::vector<std::shared_ptr<const MediumSnapshot>> media;  ///< in the order of the scene
  TriangleScene geometry;       ///< all opaque surfaces, except walls of media
  TriangleScene fixedGeometry;  ///< the scene's own surfaces, which block light for media
  SceneLights lights;
  std::vector<Sign> signs;
  Rgb background = Rgb::Zero();
  bool shadows = true;  ///< surfaces and media cast shadows on surfaces; false: previews

  /// A preview that looks nearly the same and is drawn much faster, without shadows of surfaces;
  /// nothing if it would not be faster.
  std::optional<SceneSnapshot> quick() const;

  /// Whether a medium has its own walls.
  bool hasWalls() const;
};

}  // namespace volute
