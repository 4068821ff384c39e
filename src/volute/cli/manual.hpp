// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>

#include "volute/cli/command.hpp"

namespace volute::cli {

/// The manual page volute(1) in groff's man macros, all commands in one.
std::string manualPage();

/// docs/cli/COMMAND.md.
std::string markdownPage(const Command& command);

}  // namespace volute::cli
