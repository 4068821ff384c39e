// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "volute/scene/camera_file.hpp"
#include "volute/scene/fog_file.hpp"
#include "volute/scene/scene_geometry.hpp"
#include "volute/scene/scene_lights.hpp"
#include "volute/scene/scene_look.hpp"
#include "volute/scene/scene_signs.hpp"
#include "volute/scene/scene_smoke.hpp"
#include "volute/scene/volume_layer.hpp"

namespace volute {

/// A medium of kind "volume" in a scene.
struct SceneVolume {
  std::string file;  ///< found from the scene file's folder
  Appearance appearance;
};

/// What is rendered of a volute-scene-1 file: the camera, the background, media,
/// lights, geometry, signs and billboards.
struct SceneDescription {
  CameraDescription camera;
  Rgb background = Rgb::Zero();
  std::vector<SceneVolume> volumes;
  std::vector<FogDescription> fogs;
  std::vector<SmokeDescription> smokes;
  SceneLights lights;  ///< for fog, smoke and surfaces, not volumes
  std::vector<Sign> signs;
  std::vector<SceneGeometry> geometry;
  std::vector<SceneBillboard> billboards;
  std::optional<SceneLook> look;  ///< for the viewer
};

/// Errors name the file and the path inside it, names that are unknown included. kUnsupported for
/// transforms that shear a volume.
[[nodiscard]] Result<SceneDescription> readScene(const std::string& file);

/// The same from what such a file holds, or would hold.
[[nodiscard]] Result<SceneDescription> parseScene(const nlohmann::json& json,
                                                  const std::string& file);

}  // namespace volute
