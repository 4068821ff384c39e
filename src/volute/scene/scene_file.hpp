// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "volute/io/kept_json.hpp"
#include "volute/media/camera_file.hpp"
#include "volute/media/medium_kind.hpp"
#include "volute/media/scene_lights.hpp"
#include "volute/scene/clip.hpp"
#include "volute/scene/scene_geometry.hpp"
#include "volute/scene/scene_look.hpp"
#include "volute/scene/scene_signs.hpp"

namespace volute {

/// An entry of one of a scene's lists of media.
struct MediumEntry {
  const MediumKind* kind = nullptr;
  std::string path;               ///< in the scene: "/media/0"
  KeptJson<nlohmann::json> json;  ///< what is there
};

/// The content of a scene file, with the entries of media as JSON.
struct SceneDescription {
  int version = kSceneVersion;  ///< of the format
  std::optional<CameraDescription> camera;
  Rgb background = Rgb::Zero();
  SceneLights lights;
  std::vector<MediumEntry> media;  ///< of all lists, "media" first
  std::vector<Sign> signs;
  std::vector<SceneGeometry> geometry;
  SceneClip clip;
  std::optional<SceneLook> look;  ///< for the viewer
};

/// What is meant: volute-scene-1 with all members of fields that have other defaults since.
nlohmann::json upgradedScene(nlohmann::json json);

/// From what such a file holds, or would hold. Errors name the file and the path inside it, names
/// that are unknown included.
[[nodiscard]] Result<SceneDescription> parseScene(const nlohmann::json& json,
                                                  const std::string& file);

}  // namespace volute
