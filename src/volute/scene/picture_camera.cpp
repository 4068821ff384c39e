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

/// Of a scene without a camera: from where the usual view looks, or as far from the middle.
CameraDescription framed(const Box3& bounds, const Pixels& pixels, const ViewParts& parts) {
  const Vec3 up = parts.up.value_or(Vec3::UnitZ());
  const double fov = parts.fov.value_or(Camera::kUsualFov);
  const Camera usual = Camera::framing(bounds, pixels.width, pixels.height, up, fov);
  const bool usable = !bounds.empty() && bounds.size().allFinite();
  const Vec3 middle = usable ? bounds.centre() : Vec3(Vec3::Zero());
  CameraDescription camera;
  camera.view.target = parts.target.value_or(middle);
  camera.view.eye = parts.eye.value_or(camera.view.target + usual.eye() - middle);
  camera.view.up = up;
  camera.ortho = parts.ortho;
  if (!parts.ortho)
    camera.fov = fov;
  return camera;
}

/// The scene's own, where parts of it are others.
CameraDescription changed(CameraDescription camera, const ViewParts& parts) {
  if (parts.eye || parts.target)
    camera.view = camera.viewAt(0), camera.keys.clear();
  camera.view.eye = parts.eye.value_or(camera.view.eye);
  camera.view.target = parts.target.value_or(camera.view.target);
  camera.view.up = parts.up.value_or(camera.view.up);
  if (parts.fov || parts.ortho)
    camera.fov = parts.fov, camera.ortho = parts.ortho;
  return camera;
}

}  // namespace

Result<PictureCamera> pictureCamera(const Scene& scene, std::optional<CameraDescription> asked,
                                    std::optional<Pixels> size, const ViewParts& parts) {
  if (!asked) {
    asked = scene.camera();
    if (asked && parts.any())
      asked = changed(*asked, parts);
  }
  if (!size && asked)
    size = asked->size ? asked->size : sizeOf(asked->aspect);
  const Pixels pixels = size.value_or(Pixels{800, 600});
  if (!asked && scene.media().empty() && scene.geometry().empty()) {
    return fail(ErrorCode::kInvalidData,
                "{}: has nothing to frame; expected media or geometry, or a camera", scene.path());
  }
  if (!asked && !parts.any())
    return PictureCamera{Camera::framing(scene.framed(), pixels.width, pixels.height),
                         std::nullopt};
  if (!asked)
    asked = framed(scene.framed(), pixels, parts);
  if (asked->keys.empty() && asked->view.eye == asked->view.target) {
    return fail(ErrorCode::kInvalidArgument, Hint::set(parts.eye ? "target" : "eye"),
                "the view's eye and target are the same point");
  }
  return PictureCamera{makeCamera(*asked, pixels), std::move(asked)};
}

}  // namespace volute
