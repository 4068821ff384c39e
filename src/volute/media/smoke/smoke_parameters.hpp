// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/media/field_sliders.hpp"
#include "volute/media/smoke/scene_smoke.hpp"

namespace volute {

// Sliders of smoke on a mesh that say more than their rows: doubts about what the field means, and
// the list of materials. `smoke` is a SmokeDescription.

void addQuantity(ParameterGroup& group, const void* smoke, const MediumFacts& facts);
void addUnit(ParameterGroup& group, const void* smoke, const MediumFacts& facts);
void addPotential(ParameterGroup& group, const void* smoke, const MediumFacts& facts);

/// Puts a value that must go with others into the JSON of smoke: a quantity takes along what it
/// needs, a smoke potential or a material drops what it replaces. False, with nothing done, for all
/// else.
bool setSmoke(nlohmann::ordered_json& smoke, const std::string& key,
              const nlohmann::ordered_json& value);

class SmokeMedium;

/// What soot in kg/m3 is more likely to be, by the field's name and its largest value: extinction,
/// or soot in the first smaller unit of which a fire may have as much. Puts it into the JSON of
/// smoke and says why; empty: it may well be soot in kg/m3.
std::string guessSmoke(nlohmann::ordered_json& smoke, const SmokeMedium& medium);

}  // namespace volute
