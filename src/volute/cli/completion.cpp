// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/completion.hpp"

#include <fmt/ranges.h>

#include "volute/cli/command.hpp"

namespace volute::cli {
namespace {

std::string commandNames() {
  std::vector<std::string_view> names;
  for (const Command& command : commands()) names.push_back(command.name);
  return fmt::format("{}", fmt::join(names, " "));
}

std::vector<const Option*> allOptions(const Command& command) {
  std::vector<const Option*> options;
  for (const Option& option : command.options) options.push_back(&option);
  for (const Option& option : commonOptions()) options.push_back(&option);
  return options;
}

std::string optionWords(const Command& command) {
  std::string words;
  for (const Option* option : allOptions(command)) words += fmt::format("--{} ", option->name);
  return words;
}

/// Text within single quotes of a shell.
std::string shellQuoted(std::string_view text) {
  std::string out = "'";
  for (const char c : text) c == '\'' ? out += "'\\''" : out += c;
  return out + "'";
}

/// Within zsh's '--name[help]:value:action' brackets and colons have a meaning of their own.
std::string zshText(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '[' || c == ']' || c == ':' || c == '\\')
      out += '\\';
    out += c;
  }
  return out;
}

std::string zshArgument(const Option& option) {
  std::string text = fmt::format("--{}[{}]", option.name, zshText(option.help));
  if (option.kind == ValueKind::kFlag)
    return text;
  text += fmt::format(":{}:", zshText(option.value));
  if (!option.choices.empty())
    text += fmt::format("({})", fmt::join(option.choices, " "));
  if (option.kind == ValueKind::kFile || option.kind == ValueKind::kOutput)
    text += "_files";
  return text;
}

/// Words that stand in place of files: completion and help take names.
std::string positionalWords(const Command& command) {
  if (command.name == "completion")
    return "bash zsh fish";
  if (command.name == "help")
    return commandNames();
  return "";
}

}  // namespace

std::string bashCompletion() {
  std::string out = R"(# bash completion for volute: source <(volute completion bash)
_volute() {
  local current="${COMP_WORDS[COMP_CWORD]}" previous="${COMP_WORDS[COMP_CWORD-1]}" command="" word
  local i
  for ((i = 1; i < COMP_CWORD; i++)); do
    word="${COMP_WORDS[i]}"
    if [[ "$word" != -* ]]; then command="$word"; break; fi
  done
  COMPREPLY=()
  case "$command $previous" in
)";
  for (const Command& command : commands()) {
    for (const Option* option : allOptions(command)) {
      if (option->choices.empty())
        continue;
      out +=
          fmt::format("    '{} --{}') COMPREPLY=($(compgen -W '{}' -- \"$current\")); return ;;\n",
                      command.name, option->name, fmt::join(option->choices, " "));
    }
  }
  out += "  esac\n  case \"$command\" in\n";
  out += fmt::format("    '') COMPREPLY=($(compgen -W '{} --help --version' -- \"$current\")) ;;\n",
                     commandNames());
  for (const Command& command : commands()) {
    out += fmt::format("    {}) COMPREPLY=($(compgen {} -W '{}{}' -- \"$current\")) ;;\n",
                       command.name, positionalWords(command).empty() ? "-f" : "",
                       positionalWords(command), fmt::format(" {}", optionWords(command)));
  }
  return out + "  esac\n}\ncomplete -o filenames -F _volute volute\n";
}

std::string zshCompletion() {
  std::string out =
      "#compdef volute\n# zsh completion for volute: volute completion zsh > "
      "~/.zfunc/_volute\n_volute() {\n"
      "  local -a commands\n  commands=(\n";
  for (const Command& command : commands()) {
    out += fmt::format("    {}\n",
                       shellQuoted(fmt::format("{}:{}", command.name, zshText(command.summary))));
  }
  out +=
      "  )\n  if (( CURRENT == 2 )); then _describe command commands; return; fi\n  case "
      "\"$words[2]\" in\n";
  for (const Command& command : commands()) {
    const std::string words = positionalWords(command);
    out += fmt::format(
        "    {})\n      shift words; (( CURRENT-- ))\n      _arguments {} \\\n", command.name,
        shellQuoted(words.empty() ? "*:file:_files" : fmt::format("*:name:({})", words)));
    const auto options = allOptions(command);
    for (std::size_t i = 0; i < options.size(); ++i) {
      out += fmt::format("        {}{}\n", shellQuoted(zshArgument(*options[i])),
                         i + 1 < options.size() ? " \\" : "");
    }
    out += "      ;;\n";
  }
  return out + "  esac\n}\n_volute \"$@\"\n";
}

std::string fishCompletion() {
  std::string out =
      "# fish completion for volute: volute completion fish > "
      "~/.config/fish/completions/volute.fish\n";
  for (const Command& command : commands()) {
    out += fmt::format("complete -c volute -n __fish_use_subcommand -f -a {} -d {}\n", command.name,
                       shellQuoted(command.summary));
  }
  for (const Command& command : commands()) {
    const std::string inside =
        fmt::format("complete -c volute -n '__fish_seen_subcommand_from {}'", command.name);
    if (const std::string words = positionalWords(command); !words.empty()) {
      out += fmt::format("{} -f -a {}\n", inside, shellQuoted(words));
    }
    for (const Option* option : allOptions(command)) {
      out += fmt::format("{} -l {}", inside, option->name);
      if (option->letter != 0)
        out += fmt::format(" -s {}", option->letter);
      if (option->kind == ValueKind::kFile || option->kind == ValueKind::kOutput) {
        out += " -r -F";
      } else if (option->kind != ValueKind::kFlag) {
        out += " -x";
      }
      if (!option->choices.empty())
        out += fmt::format(" -a '{}'", fmt::join(option->choices, " "));
      out += fmt::format(" -d {}\n", shellQuoted(option->help));
    }
  }
  return out;
}

}  // namespace volute::cli
