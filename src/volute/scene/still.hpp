// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
#include <vector>

#include "volute/base/progress.hpp"
#include "volute/camera/camera.hpp"
#include "volute/geometry/triangle_scene.hpp"
#include "volute/medium/any_medium.hpp"
#include "volute/render/billboard.hpp"
#include "volute/scene/scene_lights.hpp"
#include "volute/scene/scene_signs.hpp"
#include "volute/scene/smoke_layer.hpp"
#include "volute/scene/smoke_picture.hpp"

namespace volute {

/// A medium that depends on the eye, as a camera sees it.
using MediumForCamera = std::function<Result<AnyMedium>(const Camera& camera)>;

/// One instant of a scene with all that pictures of it need. Nothing in it changes, so that threads
/// may take pictures while others go on to the next instant.
struct Still {
  std::vector<AnyMedium> media;         ///< as the law sees them; smoke on meshes is not in it
  std::vector<MediumForCamera> viewed;  ///< likewise, for each camera anew
  std::vector<SmokeState> smokes;
  std::vector<std::optional<Rgb>> walls;  ///< of each smoke's mesh; nothing: not shown
  PictureLaw law;
  TriangleScene geometry;
  SceneLights lights;
  std::vector<Sign> signs;
  Rgb background = Rgb::Zero();

  /// What `volute render` shows on the processor: linear RGB. kCancelled when `progress` said so.
  /// `drawers` keep what serves the next picture of the same mesh.
  [[nodiscard]] Result<Image> picture(const Camera& camera, SmokePictures& drawers,
                                      Progress& progress) const;
};

}  // namespace volute
