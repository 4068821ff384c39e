// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>
#include <vector>

#include "volute/visibility/safety_sign.hpp"

namespace volute {

/// The "signs" of a JSON file, a scene's among them: {"signs": [{"name", "position", "normal",
/// "size", "emitting" or "C", "angle_law", "routes"}, ..]}. docs/visibility.md explains them.
/// Errors name the file and the path inside it.
[[nodiscard]] Result<std::vector<SafetySign>> readSigns(const std::string& file);

}  // namespace volute
