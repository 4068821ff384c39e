// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/scene_report.hpp"

#include <algorithm>

#include "volute/capture/image_name.hpp"
#include "volute/cli/capture_input.hpp"
#include "volute/cli/values.hpp"
#include "volute/scene/kinds.hpp"
#include "volute/scene/scene.hpp"

namespace volute::cli {
namespace {

Json pointJson(const Vec3& v) {
  return {jsonNumber(v.x()), jsonNumber(v.y()), jsonNumber(v.z())};
}

Json boxJson(const Box3& box) {
  return {pointJson(box.min), pointJson(box.max)};
}

std::string boxText(const Box3& box) {
  return fmt::format("{}  to  {} m", vectorText(box.min), vectorText(box.max));
}

std::string range(double first, double last) {
  return first == last ? fmt::format("{:g} s", first) : fmt::format("{:g} to {:g} s", first, last);
}

void addMedia(Report& report, const Scene& scene) {
  Json list = Json::array();
  std::string text;
  for (const auto& medium : scene.media()) {
    const MediumInfo& info = medium->info();
    const double first = info.times.front(), last = info.times.back();
    list.push_back({{"kind", info.kind},
                    {"file", info.file},
                    {"size", info.size},
                    {"times", {first, last}},
                    {"bounds", boxJson(info.bounds)}});
    text += fmt::format("\n  {} ({}){}{}, {}", info.file, info.kind, info.size.empty() ? "" : ": ",
                        info.size, range(first, last));
  }
  report.add("media", list, text.empty() ? "none" : text);
}

std::string countText(std::size_t count) {
  return count == 0 ? "none" : fmt::format("{}", count);
}

/// How many of the chosen frames a camera has pictures of; a film counts where it is there.
std::size_t picturesThere(const CaptureCamera& camera, const std::vector<int>& frames) {
  std::error_code ignored;
  if (camera.pictures.image.empty())
    return std::filesystem::exists(camera.pictures.video, ignored) ? frames.size() : 0;
  return static_cast<std::size_t>(std::ranges::count_if(frames, [&](int frame) {
    const int number = frame + camera.pictures.frameShift;
    return std::filesystem::exists(frameFile(camera.pictures.image, number), ignored);
  }));
}

void addCameras(Report& report, const Capture& capture, bool& damaged) {
  Json list = Json::array();
  std::string text;
  for (const CaptureCamera& camera : capture.cameras) {
    const std::size_t there = picturesThere(camera, capture.frames);
    const std::filesystem::path source = camera.pictures.image.empty()
                                             ? camera.pictures.video
                                             : std::filesystem::path(camera.pictures.image);
    const auto folder = std::filesystem::path(capture.file).parent_path();
    const std::string pictures =
        source.empty() ? "" : source.lexically_proximate(folder.empty() ? "." : folder).string();
    const bool missing = there < capture.frames.size();
    damaged = damaged || missing;
    list.push_back({{"name", camera.name},
                    {"size", {camera.camera.width(), camera.camera.height()}},
                    {"eye", pointJson(camera.camera.eye())},
                    {"pictures", pictures},
                    {"pictures_there", there}});
    text += fmt::format("\n  {}: {} x {} pixels from {} m, {}{}", camera.name,
                        camera.camera.width(), camera.camera.height(),
                        vectorText(camera.camera.eye()), pictures.empty() ? "no pictures" : pictures,
                        missing ? fmt::format(": {} of {} pictures are MISSING",
                                              capture.frames.size() - there, capture.frames.size())
                                : "");
  }
  report.add("cameras", list, text);
}

}  // namespace

Result<Report> describeScene(const std::string& path, Context& context) {
  registerUsualMedia();
  SceneOptions options;
  options.maxMemory = context.maxMemory;
  VOLUTE_ASSIGN(const auto scene, Scene::open(path, options, context.progress));
  const SceneDescription& description = scene.description();
  const auto times = scene.times();
  Report report;
  report.add("file", path).add("kind", "scene");
  addMedia(report, scene);
  report.add("times", {times.front(), times.back()}, range(times.front(), times.back()))
      .add("bounds", boxJson(scene.bounds()), boxText(scene.bounds()))
      .add("triangles", scene.geometry().triangles().size(),
           countText(scene.geometry().triangles().size()))
      .add("lights", description.lights.lamps.size(), countText(description.lights.lamps.size()))
      .add("signs", description.signs.size(), countText(description.signs.size()))
      .add("camera", scene.camera().has_value(),
           scene.camera() ? "as the scene says" : "none: the bounds are framed");
  return report;
}

Result<Report> describeCapture(const std::string& path, Context& context, bool& damaged) {
  CaptureOptions options;
  options.maxMemory = context.maxMemory;
  auto capture = openCapture(path, options);
  std::string missing;
  if (!capture) {
    missing = capture.error().message;
    // Calibration alone may be whole.
    auto calibration = openCalibration(path, options);
    if (!calibration)
      return tl::unexpected(std::move(capture.error()));
    capture = std::move(calibration);
    damaged = true;
  }
  remarkOn(*capture, context);
  Report report;
  report.add("file", path).add("kind", "capture").add("format", capture->kind);
  addCameras(report, *capture, damaged);
  const auto& frames = capture->frames;
  if (!frames.empty()) {
    report.add("frames", frames.size(), fmt::format("{}", frames.size()))
        .add("frame_numbers", {frames.front(), frames.back()},
             fmt::format("{} to {}", frames.front(), frames.back()));
  }
  const auto& [x, y, z] = capture->volume.resolution;
  if (x > 0) {
    report.add("size", {x, y, z}, fmt::format("{} x {} x {} voxels", x, y, z))
        .add("bounds", boxJson(capture->volume.bounds), boxText(capture->volume.bounds));
  }
  if (!missing.empty())
    report.add("missing", missing);
  return report;
}

}  // namespace volute::cli
