// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "volute/base/result.hpp"

namespace volute {

/// All of a text file, without a byte order mark; kInvalidData for UTF-16, kTooLarge for more than
/// `most` bytes; else as InputFile::open() and read().
[[nodiscard]] Result<std::string> readText(const std::filesystem::path& path,
                                           std::uint64_t most = 16 << 20);

/// Without spaces, ends of lines and zero bytes around it.
std::string_view trimmed(std::string_view text);

}  // namespace volute
