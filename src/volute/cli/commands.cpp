// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/commands/commands.hpp"

#include <algorithm>

#include "volute/cli/command.hpp"

namespace volute::cli {

std::span<const Command> commands() {
  static const std::vector<Command> table = {
      infoCommand(),       compressCommand(), extractCommand(),     compareCommand(),
      synthesizeCommand(), projectCommand(),  reconstructCommand(), joinCommand(),
      resampleCommand(),   renderCommand(),   fogCommand(),         visibilityCommand(),
      sweepCommand(),
#ifdef VOLUTE_WITH_VIEWER
      viewCommand(),
#endif
      mountCommand(),      benchCommand(),    helpCommand(),        manCommand(),
      completionCommand(),
  };
  return table;
}

const Command* findCommand(std::string_view name) {
  const auto found = std::ranges::find(commands(), name, &Command::name);
  return found == commands().end() ? nullptr : &*found;
}

}  // namespace volute::cli
