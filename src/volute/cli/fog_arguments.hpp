// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string_view>
#include <vector>

#include "volute/cli/arguments.hpp"
#include "volute/media/fog/fog_file.hpp"

namespace volute::cli {

/// The options of a command that say what fog there is: a scene's fog object in words.
std::vector<Option> fogOptionTable();

/// What they say about the map of this name.
[[nodiscard]] Result<FogDescription> fogOf(const Arguments& arguments, const std::string& map);

/// --sun, --sun-radiance: at most one.
std::vector<FogSun> sunsOf(const Arguments& arguments);

/// slab:BOTTOM,TOP, exponential:BOTTOM,HEIGHT, linear:Z,G,Z,G,.. or layers:BOTTOM,TOP,SHARE,..
[[nodiscard]] Result<FogProfile> parseProfile(std::string_view text);

}  // namespace volute::cli
