// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/cli/command.hpp"

namespace volute::cli {

/// Scenes and captures name files. Those outside of their own folder are remarked on, and refused
/// with --untrusted: a stranger's scene would read what it wants of this machine.
[[nodiscard]] Status checkNamedFiles(const Arguments& arguments, Context& context);

/// Says which temporary files of runs that were killed lie where this one writes, and how to delete
/// them.
void remarkOnLeftovers(const Command& command, const Arguments& arguments, Context& context);

}  // namespace volute::cli
