// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>
#include <vector>

#include "volute/cli/camera_file.hpp"
#include "volute/cli/fog_file.hpp"
#include "volute/cli/volume_layer.hpp"

namespace volute::cli {

/// A medium of kind "volume" in a scene.
struct SceneVolume {
  std::string file;  ///< found from the scene file's folder
  Appearance appearance;
};

/// What is rendered of a volute-scene-1 file: the camera, the background, media of kind
/// "volume" and "fog", and suns.
struct SceneDescription {
  CameraDescription camera;
  Rgb background = Rgb::Zero();
  std::vector<SceneVolume> volumes;
  std::vector<FogDescription> fogs;
  std::vector<FogSun> suns;  ///< they light the fog, not the volumes
};

/// Errors name the file and the path inside it. kUnsupported for parts that are valid but not
/// rendered: geometry, spot lights, signs, billboards, smoke, transforms that rotate or mirror.
[[nodiscard]] Result<SceneDescription> readScene(const std::string& file);

}  // namespace volute::cli
