// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>
#include <vector>

#include "volute/cli/arguments.hpp"
#include "volute/cli/option.hpp"
#include "volute/scene/scene_smoke.hpp"

namespace volute::cli {

/// The options that say what a scene's smoke says in JSON.
std::vector<Option> smokeOptions();

/// The smoke of a case by these options.
[[nodiscard]] Result<SmokeDescription> smokeOf(const std::string& file, const Arguments& arguments);

}  // namespace volute::cli
