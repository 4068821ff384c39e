// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>
#include <vector>

#include "volute/lighting/lamp.hpp"
#include "volute/media/field.hpp"
#include "volute/medium/sun.hpp"

namespace volute {

/// The "lights" of a scene.
struct SceneLights {
  std::vector<Sun> suns;      ///< for media that scatter their light themselves
  std::vector<Lamp> lamps;    ///< the same suns, and spots: for smoke and walls
  Rgb ambient = Rgb::Zero();  ///< radiance that comes from everywhere, whatever is in the way
  bool multiple = false;      ///< media scatter lamps' light more than once: DiffuseLight
};

Lamp lampOf(const Sun& sun);

/// Tables of members, one for each kind of light.
std::span<const FieldTable* const> lightTables();
const FieldTable& sunFields();

[[nodiscard]] Result<SceneLights> parseLights(const nlohmann::json& json,
                                              const FieldOrigin& origin);

}  // namespace volute
