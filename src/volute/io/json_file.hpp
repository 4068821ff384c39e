// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "volute/base/result.hpp"
#include "volute/io/json_check.hpp"

namespace volute {

/// A whole JSON file of at most 128 MiB that passes checkJson(); errors name the file and the line.
[[nodiscard]] Result<nlohmann::json> readJson(const std::filesystem::path& file,
                                              const JsonLimits& limits = {});

/// The outermost object, with null where it has a list or an object: which members are there, and
/// what format the file says that it has, in the memory of its text.
[[nodiscard]] Result<nlohmann::json> readOutermostJson(const std::filesystem::path& file);

/// Each text in the file that is no member's name, in the memory of the file's text.
[[nodiscard]] Status forEachJsonText(const std::filesystem::path& file,
                                     const std::function<void(const std::string&)>& function);

}  // namespace volute
