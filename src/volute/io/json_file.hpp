// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>

#include "volute/base/result.hpp"

namespace volute {

/// A whole JSON file of at most 16 MiB and not too deep (json_depth.hpp), no member of which is in
/// its object twice; errors name the file and the line.
/// @param mostMembers  of one object
[[nodiscard]] Result<nlohmann::json> readJson(const std::filesystem::path& file,
                                              std::size_t mostMembers = SIZE_MAX);

}  // namespace volute
