// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>
#include <vector>

#include "volute/base/advice.hpp"
#include "volute/cli/command.hpp"

namespace volute::cli {

/// The words that follow the command's name, checked against its table: known options, values
/// within limits, what is required, what excludes what. With --help among them nothing is required.
/// Errors are kInvalidArgument.
[[nodiscard]] Result<Arguments> parseArguments(const Command& command,
                                               const std::vector<std::string>& words);

/// Settings as options of a command.
SettingText optionsOf(const Command& command);

/// Where the command's name stands: common options may come before it. words.size() when there is
/// none.
[[nodiscard]] Result<std::size_t> findCommandWord(const std::vector<std::string>& words);

}  // namespace volute::cli
