// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>

#include "volute/media/camera_file.hpp"
#include "volute/scene/scene.hpp"

namespace volute {

/// What somebody says of a view; the rest is the scene's own camera's, or that of one that frames
/// its bounds.
struct ViewParts {
  std::optional<Vec3> eye{}, target{}, up{};
  std::optional<double> fov{}, ortho{};  ///< as of CameraDescription; at most one

  bool any() const { return eye || target || up || fov || ortho; }
};

/// What a picture of a scene is taken with.
struct PictureCamera {
  Camera camera;
  std::optional<CameraDescription> description;  ///< nothing: the camera frames Scene::framed()
};

/// The camera `asked` for, else the scene's, else one that frames its bounds, with the `parts`
/// asked for. Its picture has the `size` asked for, else the description's, else 800 x 600 pixels,
/// or the largest within that of the shape a glTF states. kInvalidData where there is nothing to
/// frame; kInvalidArgument where the parts make no view.
[[nodiscard]] Result<PictureCamera> pictureCamera(const Scene& scene,
                                                  std::optional<CameraDescription> asked,
                                                  std::optional<Pixels> size,
                                                  const ViewParts& parts = {});

}  // namespace volute
