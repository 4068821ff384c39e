// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

#include "volute/base/result.hpp"

namespace volute {

/// A whole JSON file of at most 16 MiB and not too deep (json_depth.hpp); errors name the file and
/// the line.
[[nodiscard]] Result<nlohmann::json> readJson(const std::filesystem::path& file);

}  // namespace volute
