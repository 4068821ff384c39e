// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/cli/command.hpp"

namespace volute::cli {

// One function for each command: its entry in the table, with the function that runs it.
Command benchCommand();
Command compareCommand();
Command completionCommand();
Command compressCommand();
Command extractCommand();
Command helpCommand();
Command infoCommand();
Command joinCommand();
Command manCommand();
Command mountCommand();
Command projectCommand();
Command reconstructCommand();
Command renderCommand();
Command resampleCommand();
Command fogCommand();
Command sweepCommand();
Command synthesizeCommand();
Command viewCommand();  ///< in builds with the viewer only
Command visibilityCommand();

}  // namespace volute::cli
