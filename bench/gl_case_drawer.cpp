// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "bench/gl_case_drawer.hpp"

#include <limits>

namespace volute::bench {

Result<Image> GlCaseDrawer::picture(const GlCase& one, int width, int height) {
  const Camera camera = one.camera(0, width, height);
  if (one.paperFog)
    return one.paperFog->render(camera, passes_);
  VOLUTE_ASSIGN(const auto ends, findSigns(one, camera));
  VOLUTE_ASSIGN(auto image, renderer_.render(camera, one.scene(0), {}, quiet_, nullptr, ends));
  if (one.signs.empty())
    return image;
  VOLUTE_ASSIGN(const auto light, signLight(one));
  for (std::size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] += light.pixels[i];
  return image;
}

Status GlCaseDrawer::frame(const GlCase& one, const Camera& camera, int frame) {
  if (one.paperFog) {
    one.paperFog->draw(camera, passes_);
    return {};
  }
  VOLUTE_ASSIGN(const auto ends, findSigns(one, camera));
  VOLUTE_TRY(renderer_.draw(camera, one.scene(frame), GlQuantity::kLight, quiet_, ends));
  if (!one.signs.empty())
    VOLUTE_TRY(signLight(one));
  return {};
}

std::vector<GlPassTime> GlCaseDrawer::takePasses() {
  auto times = renderer_.takePasses();
  for (GlPassTime& time : passes_.take()) times.push_back(std::move(time));
  return times;
}

/// How far away the signs of a case are that rays meet; no distances without signs.
Result<std::vector<float>> GlCaseDrawer::findSigns(const GlCase& one, const Camera& camera) {
  std::vector<float> ends;
  if (one.signs.empty())
    return ends;
  VOLUTE_ASSIGN(const auto found, renderer_.findSigns(camera, one.signs, {}));
  ends.assign(static_cast<std::size_t>(camera.width()) * camera.height(),
              std::numeric_limits<float>::infinity());
  for (const SignPixel& pixel : found) ends[pixel.pixel] = pixel.distance;
  return ends;
}

/// Through the depths that were drawn last.
Result<Image> GlCaseDrawer::signLight(const GlCase& one) {
  return renderer_.signLight(std::vector<float>(one.signs.size(), kEmittingPower));
}

}  // namespace volute::bench
