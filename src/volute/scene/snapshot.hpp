// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "volute/geometry/triangle_scene.hpp"
#include "volute/media/medium_at.hpp"
#include "volute/media/scene_lights.hpp"
#include "volute/optics/visibility.hpp"
#include "volute/render/sign.hpp"

namespace volute {

/// A scene at one instant, with all that pictures of it need. Nothing in it changes: threads may
/// take pictures while others go on to the next instant.
struct Snapshot {
  double time = 0;  ///< [s], of the scene
  PictureLaw law;   ///< that everything but signs is seen through
  std::vector<std::shared_ptr<const MediumAt>> media;  ///< in the order of the scene
  TriangleScene geometry;                              ///< all that is opaque, walls of media apart
  TriangleScene fixedGeometry;  ///< the scene's own, which stands in the light of media
  SceneLights lights;
  std::vector<Sign> signs;
  Rgb background = Rgb::Zero();
  bool shadows = true;  ///< surfaces and media keep lamps' light from surfaces; false: previews

  /// What looks nearly the same and is drawn much sooner, without shadows of surfaces; nothing
  /// where that would be no sooner.
  std::optional<Snapshot> quick() const;

  /// Whether a medium has walls of its own.
  bool hasWalls() const;
};

}  // namespace volute
