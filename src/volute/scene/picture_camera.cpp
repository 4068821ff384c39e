// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/picture_camera.hpp"

namespace volute {

Result<PictureCamera> pictureCamera(const Scene& scene, std::optional<CameraDescription> asked,
                                    std::optional<Pixels> size, const Vec3& up) {
  if (!asked)
    asked = scene.camera();
  if (!size && asked)
    size = asked->size;
  const Pixels pixels = size.value_or(Pixels{800, 600});
  if (asked)
    return PictureCamera{makeCamera(*asked, pixels), std::move(asked)};
  if (scene.media().empty() && scene.geometry().empty()) {
    return fail(ErrorCode::kInvalidData,
                "{}: has nothing to frame; expected media or geometry, or a camera", scene.path());
  }
  return PictureCamera{Camera::framing(scene.bounds(), pixels.width, pixels.height, up),
                       std::nullopt};
}

}  // namespace volute
