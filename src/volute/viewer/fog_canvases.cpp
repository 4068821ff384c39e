// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// The maps of fog in a SceneDocument that a person paints.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "volute/io/image_file.hpp"
#include "volute/media/fog/fog_scene_medium.hpp"
#include "volute/scene/scene_names.hpp"
#include "volute/viewer/scene_document.hpp"
#include "volute/volume_files/volume_input.hpp"

namespace volute {
namespace {

using Json = nlohmann::ordered_json;

/// A fog whose map can be painted, and its place in the scene.
struct Canvas {
  std::shared_ptr<FogSceneMedium> fog;
  std::string path;  ///< "/media/0"
  std::size_t medium = 0;
};

std::vector<Canvas> canvasesOf(const Scene& scene) {
  std::vector<Canvas> canvases;
  for (std::size_t i = 0; i < scene.media().size(); ++i) {
    auto fog = std::dynamic_pointer_cast<FogSceneMedium>(scene.media()[i]);
    if (fog && fog->paintable())
      canvases.push_back({std::move(fog), scene.description().media[i].path, i});
  }
  return canvases;
}

Result<Canvas> canvasAt(const Scene& scene, std::size_t i) {
  auto canvases = canvasesOf(scene);
  if (i < canvases.size())
    return std::move(canvases[i]);
  return fail(ErrorCode::kNotFound, "{}: there is no map of fog to paint on any more",
              scene.path());
}

}  // namespace

std::string unsavedMaps(const std::vector<FogCanvas>& canvases) {
  std::string names;
  for (const FogCanvas& canvas : canvases) {
    if (canvas.unsaved)
      names += (names.empty() ? "" : ", ") + canvas.name;
  }
  return names;
}

std::vector<FogCanvas> SceneDocument::canvases() const {
  std::vector<FogCanvas> canvases;
  for (const Canvas& canvas : canvasesOf(scene_)) {
    const FogDescription& fog = canvas.fog->description();
    const std::string& file = fog.maps.front();
    canvases.push_back({std::filesystem::path(file).filename().string(), file,
                        fog.placement.sigmaMax, canvas.fog->shown()->mapAt(0), fog.wind,
                        fog.borderInWind(), canvas.fog->unsaved()});
  }
  return canvases;
}

Status SceneDocument::setFogMap(std::size_t canvas, std::vector<double> coefficients,
                                bool unsaved) {
  VOLUTE_ASSIGN(const Canvas found, canvasAt(scene_, canvas));
  auto painted = std::make_shared<FogSceneMedium>(*found.fog);  // jobs may hold the one before
  VOLUTE_TRY(painted->paint(std::move(coefficients), unsaved));
  scene_.replace(found.medium, std::move(painted));
  return {};
}

Status SceneDocument::saveFogMap(std::size_t canvas, const std::string& target, const Image& map) {
  const float most = *std::ranges::max_element(map.pixels);
  if (most > 1 && extensionOf(target) == ".png") {
    return fail(ErrorCode::kInvalidArgument,
                "{}: the map is up to {:.3g} times its largest value, which a .png cannot hold; "
                "save an .exr",
                target, most);
  }
  VOLUTE_ASSIGN(const Canvas found, canvasAt(scene_, canvas));
  VOLUTE_TRY(checkNotShown(target, found.fog->description().maps.front()));
  VOLUTE_TRY(writeMap(target, map));
  found.fog->savedAs(target);
  Json json = scene_.json();
  Json& shown = json[Json::json_pointer(found.path)]["map"];
  const Json name = nameFrom(target, file_, std::filesystem::path(target).filename().string());
  const Json before = std::exchange(shown, name);
  if (before == name)
    return {};
  // What can be undone is of the scene with this map.
  std::ptrdiff_t others = 0;
  for (const Json& medium : json.at("media")) others += medium.value("map", Json()) == before;
  const auto rename = [&](Json& scene) {
    for (Json& medium : scene["media"]) {
      if (medium.value("map", Json()) == before)
        medium["map"] = name;
    }
  };
  others > 0 ? history_.clear() : history_.changeAll(rename);
  const bool unchanged = scene_.json() == saved_;
  scene_.note(std::move(json));
  if (unchanged && !scene_.isFile())
    saved_ = scene_.json();
  return {};
}

}  // namespace volute
