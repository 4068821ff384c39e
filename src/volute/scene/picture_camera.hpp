// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>

#include "volute/media/camera_file.hpp"
#include "volute/scene/scene.hpp"

namespace volute {

/// What a picture of a scene is taken with.
struct PictureCamera {
  Camera camera;
  std::optional<CameraDescription> description;  ///< nothing: the camera frames Scene::bounds()
};

/// The camera `asked` for, else the scene's, else one that frames its bounds. Its picture has the
/// `size` asked for, else the description's, else 800 x 600 pixels, or the
/// largest within that of the shape a glTF states. kInvalidData where there is
/// nothing to frame.
/// @param up  of a camera that frames the bounds
[[nodiscard]] Result<PictureCamera> pictureCamera(const Scene& scene,
                                                  std::optional<CameraDescription> asked,
                                                  std::optional<Pixels> size,
                                                  const Vec3& up = Vec3::UnitZ());

}  // namespace volute
