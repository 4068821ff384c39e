// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>
#include <vector>

#include "volute/cli/camera_file.hpp"
#include "volute/cli/fog_file.hpp"
#include "volute/cli/scene_lights.hpp"
#include "volute/cli/scene_signs.hpp"
#include "volute/cli/scene_smoke.hpp"
#include "volute/cli/volume_layer.hpp"

namespace volute::cli {

/// A medium of kind "volume" in a scene.
struct SceneVolume {
  std::string file;  ///< found from the scene file's folder
  Appearance appearance;
};

/// What is rendered of a volute-scene-1 file: the camera, the background, media, lights and signs.
struct SceneDescription {
  CameraDescription camera;
  Rgb background = Rgb::Zero();
  std::vector<SceneVolume> volumes;
  std::vector<FogDescription> fogs;
  std::vector<SmokeDescription> smokes;
  SceneLights lights;  ///< for fog and smoke, not volumes
  std::vector<Sign> signs;
};

/// Errors name the file and the path inside it. kUnsupported for parts that are valid but not
/// rendered: geometry, billboards, transforms that rotate or mirror.
[[nodiscard]] Result<SceneDescription> readScene(const std::string& file);

}  // namespace volute::cli
