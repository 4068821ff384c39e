// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/film/draw_picture.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include "volute/film/render_request.hpp"

namespace volute {
namespace {

Result<RenderRequest> requestOf(const PictureOptions& given) {
  constexpr int kMaxSide = 32768, kMaxSamples = 256;
  RenderRequest request;
  request.frames.time = given.time;
  request.camera = given.camera;
  if (given.size) {
    const auto [width, height] = *given.size;
    if (std::min(width, height) < 1 || std::max(width, height) > kMaxSide)
      return failFor("size", ErrorCode::kInvalidArgument,
                     "{} x {} pixels; expected 1 to {} on each side", width, height, kMaxSide);
    request.size = Pixels{width, height};
  }
  if (!(given.exposure >= 0) || !std::isfinite(given.exposure))
    return failFor("exposure", ErrorCode::kInvalidArgument, "{}; expected 0 or more",
                   given.exposure);
  if (given.samples < 1 || given.samples > kMaxSamples)
    return failFor("samples", ErrorCode::kInvalidArgument, "{}; expected 1 to {}", given.samples,
                   kMaxSamples);
  if (!(given.shutter >= 0 && given.shutter <= 1))
    return failFor("shutter", ErrorCode::kInvalidArgument, "{}; expected 0 to 1", given.shutter);
  request.exposure = given.exposure;
  request.tone = given.tone;
  request.samples = given.samples;
  request.shutter = given.shutter;
  return request;
}

}  // namespace

Result<Image> drawPicture(const std::string& path, const PictureOptions& given,
                          SceneOptions options, Progress& progress) {
  VOLUTE_ASSIGN(const auto request, requestOf(given));
  addUsualMembers(path, {.moves = given.shutter > 0}, options);
  VOLUTE_ASSIGN(auto scene, Scene::open(path, options, progress));
  FilmJob job{std::move(scene), Camera::framing({}, 1, 1), {}, std::make_unique<CpuRenderer>()};
  VOLUTE_TRY(prepare(job, request, options.maxMemory, progress));
  VOLUTE_ASSIGN(auto development, developmentOf(request, job));
  return visiblePicture(job, development, progress);
}

}  // namespace volute
