// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "volute/media/field_sliders.hpp"
#include "volute/media/fog/fog_file.hpp"

namespace volute {

/// The sliders of "profile", which may be null.
void addProfile(ParameterGroup& group, const void* profile, const MediumFacts& facts);

/// Puts a value that must go with others into a fog's JSON: the wind, the kind of a profile, a
/// height of it, which stays on its side of its neighbours, the place of its top. False, with
/// nothing done, for all else.
/// @param key  below the fog: "profile/knots/1"
bool setFog(nlohmann::ordered_json& json, const FogDescription& fog, const std::string& key,
            const std::vector<double>& value);

/// A knot or a layer of a profile is there twice, or no more. Says in a sentence what was done;
/// nothing where `key`, as above, names none. kInvalidArgument where the profile needs it.
[[nodiscard]] Result<std::optional<std::string>> editProfile(nlohmann::ordered_json& fog,
                                                             const std::string& key, bool more);

}  // namespace volute
