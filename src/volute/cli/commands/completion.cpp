// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/completion.hpp"

#include "volute/cli/commands/commands.hpp"

namespace volute::cli {
namespace {

Status runCompletion(const Arguments& arguments, Context& context) {
  const std::string& shell = arguments.positional(0);
  if (shell == "bash") {
    context.print(bashCompletion());
  } else if (shell == "zsh") {
    context.print(zshCompletion());
  } else if (shell == "fish") {
    context.print(fishCompletion());
  } else {
    return fail(ErrorCode::kInvalidArgument,
                "'{}' is not a known shell; expected bash, zsh or fish", shell);
  }
  return {};
}

}  // namespace

Command completionCommand() {
  return {
      .name = "completion",
      .summary = "Prints a script that lets a shell complete Volute's commands and options",
      .examples = {"source <(volute completion bash)", "volute completion zsh > ~/.zfunc/_volute",
                   "volute completion fish > ~/.config/fish/completions/volute.fish"},
      .description = "The script is made from the same tables as the help.",
      .positionals = {{.name = "SHELL", .help = "bash, zsh or fish", .file = false}},
      .run = runCompletion};
}

}  // namespace volute::cli
