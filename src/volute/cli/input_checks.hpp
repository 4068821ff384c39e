// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/base/file_name.hpp"
#include "volute/cli/arguments.hpp"
#include "volute/cli/command.hpp"

namespace volute::cli {

/// kInvalidArgument where an output is one of the files that are read, under whatever name: a
/// positional, an option's file, or what a positional .json names (a scene's maps, a capture's
/// masks). Patterns count when they are the same; project checks each of its pictures besides.
[[nodiscard]] Status checkNothingOverwritten(const Command& command, const Arguments& arguments);

/// Scenes and captures name files. Those outside of their own folder are remarked on, and refused
/// with --untrusted: a stranger's scene would read what it wants of this machine.
[[nodiscard]] Status checkNamedFiles(const Command& command, const Arguments& arguments,
                                     Context& context);

/// Says which temporary files of runs that were killed lie where this one writes, and how to delete
/// them.
void remarkOnLeftovers(const Command& command, const Arguments& arguments, Context& context);

}  // namespace volute::cli
