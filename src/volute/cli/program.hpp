// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstddef>

#include "volute/cli/command.hpp"

namespace volute::cli {

/// Frames, blocks and pictures come and go: what is freed stays with the process, up to so many
/// bytes and at least 32 MiB. If it went back to the system, up to a third of the time would be
/// spent on having fresh pages cleared and mapped. Each program begins with 0, readers too.
void keepFreedMemory(std::size_t bytes);

/// The whole program: finds the command, parses, runs it, and says what went wrong. Returns the
/// exit code: 0 done, 1 could not, 2 wrong usage.
int runProgram(int argc, char** argv);

/// A program of one command: argv has what follows its name.
int runProgram(const Command& command, int argc, char** argv);

}  // namespace volute::cli
