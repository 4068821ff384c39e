// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>

#include "volute/base/result.hpp"

namespace volute {

/// Prints a page of this program's as a PDF, by Chromium without a window (chromium,
/// chromium-browser or google-chrome in the PATH), which is kept from the network. kUnsupported
/// when there is none; it ends after two minutes.
[[nodiscard]] Status printPdf(const std::filesystem::path& html, const std::filesystem::path& pdf);

}  // namespace volute
