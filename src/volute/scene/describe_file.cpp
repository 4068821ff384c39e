// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/describe_file.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "volute/base/plain_number.hpp"
#include "volute/io/image_file.hpp"
#include "volute/media/medium_kind.hpp"
#include "volute/scene/kinds.hpp"
#include "volute/scene/scene.hpp"

namespace volute {
namespace {

using OrderedJson = nlohmann::ordered_json;

std::string range(double first, double last) {
  return first == last ? fmt::format("{} s", plainNumber(first))
                       : fmt::format("{} to {} s", plainNumber(first), plainNumber(last));
}

void addMedia(Report& report, const Scene& scene) {
  OrderedJson list = OrderedJson::array();
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

Result<Report> describeScene(const std::string& path, Reading& reading) {
  SceneOptions options;
  options.maxMemory = reading.maxMemory;
  VOLUTE_ASSIGN(const auto scene, Scene::open(path, options, reading.progress));
  const SceneDescription& description = scene.description();
  const auto times = scene.times();
  Report report;
  report.add("file", path).add("kind", "scene");
  addMedia(report, scene);
  report.add("times", {times.front(), times.back()}, range(times.front(), times.back()))
      .add("bounds", boxJson(scene.bounds()), boxText(scene.bounds()))
      .add("triangles", scene.geometry().flat().size(), countText(scene.geometry().flat().size()))
      .add("level_sets", scene.geometry().curved().size(),
           countText(scene.geometry().curved().size()))
      .add("lights", description.lights.lamps.size(), countText(description.lights.lamps.size()))
      .add("signs", description.signs.size(), countText(description.signs.size()))
      .add("camera", scene.camera().has_value(),
           scene.camera() ? "as the scene says" : "none: the bounds are framed");
  return report;
}

Result<Report> describePicture(const std::string& path, Reading& reading) {
  VOLUTE_ASSIGN(const auto image, readImage(path, {.maxMemory = reading.maxMemory}));
  Report report;
  report.add("file", path).add("kind", "picture");
  std::error_code error;
  if (const auto bytes = std::filesystem::file_size(path, error); !error)
    report.add("bytes", bytes, bytesText(bytes));
  report
      .add("size", {image.width, image.height},
           fmt::format("{} x {} pixels", image.width, image.height))
      .add("channels", image.channels, fmt::format("{}", image.channels));
  ValueRange range;
  range.add(image.pixels);
  range.addTo(report);
  return report;
}

FileDescription whole(Report report) {
  return {std::move(report)};
}

}  // namespace

Result<FileDescription> describeFile(const std::string& path, const DescribeRequest& request,
                                     Reading& reading) {
  registerUsualMedia();
  if (isScenePath(path))
    return describeScene(path, reading).map(whole);
  if (isPicturePath(path))
    return describePicture(path, reading).map(whole);
  return mediumKindOf(path, true)->describe(path, request, reading);
}

}  // namespace volute
