// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>

#include "volute/base/result.hpp"

namespace volute {

/// Writes all of a file, which appears whole or not at all; "-" is standard output.
[[nodiscard]] Status writeFile(const std::filesystem::path& target,
                               std::span<const std::byte> bytes);
[[nodiscard]] Status writeFile(const std::filesystem::path& target, std::string_view text);

}  // namespace volute
