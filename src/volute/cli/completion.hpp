// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>

namespace volute::cli {

/// Completion scripts: commands, options, choices and file names, from the tables of the commands.
std::string bashCompletion();
std::string zshCompletion();
std::string fishCompletion();

}  // namespace volute::cli
