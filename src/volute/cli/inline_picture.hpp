// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <string>

#include "volute/base/result.hpp"

namespace volute::cli {

/// A .png file as the source of an image in a page that needs no other files.
[[nodiscard]] Result<std::string> inlinePicture(const std::filesystem::path& png);

}  // namespace volute::cli
