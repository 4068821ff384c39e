// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "volute/base/result.hpp"

namespace volute {

/// The JSON of a glTF file, which says nothing that would be left out without a word: its version
/// is 2, no member is twice, and what places nodes and colours materials has as many numbers as it
/// must. Errors name the file and the place.
[[nodiscard]] Result<nlohmann::json> parseGltf(std::string_view text, const std::string& file);

}  // namespace volute
