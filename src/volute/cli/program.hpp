// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/cli/command.hpp"

namespace volute::cli {

/// The whole program: finds the command, parses, runs it, and says what went wrong. Returns the
/// exit code: 0 done, 1 could not, 2 wrong usage.
int runProgram(int argc, char** argv);

/// A program of one command: argv has what follows its name.
int runProgram(const Command& command, int argc, char** argv);

}  // namespace volute::cli
