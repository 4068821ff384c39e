// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>

#include "volute/cli/command.hpp"

namespace volute::cli {

/// What `volute` alone prints: every command with its line.
std::string overviewText();

/// What `volute COMMAND --help` prints: an example, what it does, its options with their defaults.
std::string helpText(const Command& command);

/// "volute compress INPUT --output OUT.volute (--rms R | --psnr DB) [options]".
std::string usageLine(const Command& command);

/// The help of an option with its choices and default: "renderer: auto, cpu; default auto".
std::string optionHelp(const Option& option);

/// "-o, --output FILE".
std::string optionNames(const Option& option);

}  // namespace volute::cli
