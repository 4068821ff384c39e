// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "volute/cli/arguments.hpp"
#include "volute/cli/context.hpp"
#include "volute/cli/option.hpp"
#include "volute/lighting/light_cache.hpp"
#include "volute/scene/scene_smoke.hpp"

namespace volute::cli {

/// The options that say what a scene's smoke says in JSON.
std::vector<Option> smokeOptions();

/// The smoke of a case by these options.
[[nodiscard]] Result<SmokeDescription> smokeOf(const std::string& file, const Arguments& arguments);

/// The options that say where the light of lamps in smoke is kept.
std::vector<Option> lightCacheOptions();

/// By these options; nothing when it is not to be kept, or cannot.
[[nodiscard]] Result<std::optional<LightCache>> lightCache(const Arguments& arguments,
                                                           Context& context);

}  // namespace volute::cli
