// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <string>

#include "volute/base/result.hpp"

namespace volute {

/// Where an output is, a file or a folder: symbolic links lead there, the last to what need not be
/// there. kIo where they go round.
/// @param name  of the output in errors
[[nodiscard]] Result<std::filesystem::path> outputPlace(const std::filesystem::path& target,
                                                        const std::string& name);

}  // namespace volute
