// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "volute/base/team_checks.hpp"
#include "volute/cli/arguments.hpp"
#include "volute/cli/command.hpp"

// What the program does as one of several processes that mpirun started.

namespace volute::cli {

/// kInvalidArgument when several processes were started for a command that one does.
[[nodiscard]] Status checkRanks(const Command& command);

/// The processes that were started together, after they agreed on being the same program with the
/// same arguments; this one alone without mpirun.
[[nodiscard]] Result<std::unique_ptr<Team>> openTeamFor(const Command& command,
                                                        const std::vector<std::string>& words);

/// --stats, of commands that several ranks share; of some kinds of input alone, or of all.
Option statsOption(std::vector<std::string_view> kinds = {});

/// Where --stats is given, rank 0 writes `own` and, as "ranks", what each rank did: the units of
/// each stage, CPU time, seconds that it waited, memory. Collective.
[[nodiscard]] Status writeStats(const Arguments& arguments, Context& context, Json own);

}  // namespace volute::cli
