// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/fog/sunlit_fog.hpp"
#include "volute/lighting/lamp.hpp"

namespace volute {

/// The "lights" of a scene.
struct SceneLights {
  std::vector<FogSun> suns;   ///< for fog
  std::vector<Lamp> lamps;    ///< the same suns, and spots: for smoke and walls
  Rgb ambient = Rgb::Zero();  ///< radiance that comes from everywhere, whatever is in the way
};

/// A list of {"kind": "sun", "direction", "radiance"}, {"kind": "spot", "position", "target",
/// "angle", "intensity", "radius", "edge"} and {"kind": "ambient", "radiance"}. A sun's `direction`
/// is the way its light travels, so it points down, and its `radiance` is what arrives on a surface
/// that faces it. A spot's `angle` [degrees] is its cone's from side to side, `intensity` the power
/// per solid angle in it.
[[nodiscard]] Result<SceneLights> parseLights(const nlohmann::json& json, const std::string& file,
                                              const std::string& path);

}  // namespace volute
