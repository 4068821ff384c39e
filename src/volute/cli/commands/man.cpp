// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/commands/commands.hpp"
#include "volute/cli/manual.hpp"
#include "volute/report/report.hpp"
#include "volute/scene/scene_tables.hpp"

namespace volute::cli {
namespace {

Status runMan(const Arguments& arguments, Context& context) {
  if (arguments.flag("schema") || arguments.flag("members")) {
    context.print(arguments.flag("members") ? sceneMembersPage() : dumpJson(sceneSchema()) + "\n");
    return {};
  }
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
          .description = "The page uses groff's man macros and covers all commands.",
          .options = {{.name = "markdown",
                       .kind = ValueKind::kText,
                       .value = "COMMAND",
                       .help = "print the page of one command as Markdown, as in docs/cli"},
                      {.name = "schema", .help = "print the JSON Schema of scenes"},
                      {.name = "members", .help = "print all members of scenes as Markdown"}},
          .oneOf = {{{"markdown", "schema", "members"}, false}},
          .run = runMan};
}

}  // namespace volute::cli
