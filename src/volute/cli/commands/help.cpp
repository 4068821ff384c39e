// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/help.hpp"

#include "volute/cli/commands/commands.hpp"

namespace volute::cli {
namespace {

Status runHelp(const Arguments& arguments, Context& context) {
  if (arguments.positionals().empty()) {
    context.print(overviewText());
    return {};
  }
  const std::string& name = arguments.positional(0);
  const Command* command = findCommand(name);
  if (!command) {
    return fail(ErrorCode::kInvalidArgument, "there is no command '{}'; 'volute help' lists them",
                name);
  }
  context.print(helpText(*command));
  return {};
}

}  // namespace

Command helpCommand() {
  return {.name = "help",
          .summary = "Shows the help of a command",
          .examples = {"volute help compress"},
          .description = "Without a name, it lists the commands.",
          .positionals = {{.name = "COMMAND",
                           .help = "the command to explain",
                           .optional = true,
                           .file = false}},
          .run = runHelp};
}

}  // namespace volute::cli
