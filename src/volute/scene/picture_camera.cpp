// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/picture_camera.hpp"

#include <algorithm>
#include <cmath>

namespace volute {
namespace {

/// The largest of this shape within the usual size.
std::optional<Pixels> sizeOf(std::optional<double> aspect) {
  constexpr Pixels kUsual{800, 600};
  if (!aspect || !(*aspect > 0))
    return std::nullopt;
  const auto side = [](double pixels) {
    return static_cast<int>(std::lround(std::max(pixels, 1.0)));
  };
  return Pixels{side(std::min<double>(kUsual.width, kUsual.height * *aspect)),
                side(std::min<double>(kUsual.height, kUsual.width / *aspect))};
}

}  // namespace

Result<PictureCamera> pictureCamera(const Scene& scene, std::optional<CameraDescription> asked,
                                    std::optional<Pixels> size, const Vec3& up) {
  if (!asked)
    asked = scene.camera();
  if (!size && asked)
    size = asked->size ? asked->size : sizeOf(asked->aspect);
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
