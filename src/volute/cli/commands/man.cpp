// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/commands/commands.hpp"
#include "volute/cli/manual.hpp"

namespace volute::cli {
namespace {

Status runMan(const Arguments& arguments, Context& context) {
  const auto name = arguments.find<std::string>("markdown");
  if (!name) {
    context.print(manualPage());
    return {};
  }
  const Command* command = findCommand(*name);
  if (!command) {
    return fail(ErrorCode::kInvalidArgument, "there is no command '{}'; 'volute help' lists them",
                *name);
  }
  context.print(markdownPage(*command));
  return {};
}

}  // namespace

Command manCommand() {
  return {.name = "man",
          .summary = "Prints the manual page",
          .examples = {"volute man | man -l -", "volute man > /usr/local/share/man/man1/volute.1"},
          .description = "The page is in groff's man macros and holds all commands.",
          .options = {{.name = "markdown",
                       .kind = ValueKind::kText,
                       .value = "COMMAND",
                       .help = "print the page of one command as Markdown, as in docs/cli"}},
          .run = runMan};
}

}  // namespace volute::cli
