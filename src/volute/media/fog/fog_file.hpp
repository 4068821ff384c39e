// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "volute/fog/fog_medium.hpp"
#include "volute/fog/sunlit_fog.hpp"
#include "volute/media/clock.hpp"

namespace volute {

/// No fog above a map of heights.
struct FogTopDescription {
  std::string file;
  FogPlacement placement;  ///< its sigmaMax is the height of a pixel of value 1 [m]
};

/// A medium of kind "fog" in a scene, or what `volute fog` was asked for.
struct FogDescription {
  std::string where;  ///< begins every error: "scene.json: /media/0"
  /// Pictures, one a time; or one name: a picture, a pattern of pictures, or a volume one voxel
  /// high.
  std::vector<std::string> maps;
  std::vector<double> times;  ///< [s], of each map; empty: the volume's own, else 25 a second
  FogPlacement placement;
  FogColour colour = FogColour::kRefuse;
  FogOptions options;
  FogProfile profile;
  std::optional<FogTopDescription> top;
  Vec3 wind = Vec3::Zero();  ///< [m/s], in the scene's time
  Clock clock;
  SunScattering scattering;
  /// Pictures by a table of polar prefix sums where it serves (degree 1 to 3, no dropped details,
  /// no top, no exponential profile, no suns): |dT| < 1/512. Else every ray is walked, exactly.
  bool polar = false;
};

/// A fog object of a scene. Names of files are found from the folder of `file`. Errors name the
/// file and the path inside it, keys that are unknown included.
[[nodiscard]] Result<FogDescription> parseFog(const nlohmann::json& json, const std::string& file,
                                              const std::string& path);

/// {"kind": "slab", "bottom", "top"}, {"kind": "exponential", "bottom", "height"}, {"kind":
/// "linear", "knots": [[height, value], ..]} or {"kind": "layers", "layers": [[bottom, top, share],
/// ..]}.
[[nodiscard]] Result<FogProfile> parseFogProfile(const nlohmann::json& json,
                                                 const std::string& file, const std::string& path);

}  // namespace volute
