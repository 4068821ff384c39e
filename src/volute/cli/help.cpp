// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/help.hpp"

#include <fmt/ranges.h>

#include <algorithm>

namespace volute::cli {
namespace {

constexpr std::size_t kWidth = 100;

/// Breaks text between words; lines after the first begin with `indent` spaces, and so do new
/// paragraphs.
std::string wrapped(std::string_view text, std::size_t indent, std::size_t column) {
  std::string out;
  while (!text.empty()) {
    const std::size_t end = text.find_first_of(" \n");
    const std::string_view word = text.substr(0, end);
    if (column > indent && column + 1 + word.size() > kWidth) {
      out += '\n' + std::string(indent, ' ');
      column = indent;
    } else if (column > indent) {
      out += ' ';
      ++column;
    }
    out += word;
    column += word.size();
    if (end == std::string_view::npos)
      break;
    if (text.substr(end).starts_with("\n\n")) {
      out += "\n\n" + std::string(indent, ' ');
      column = indent;
      text.remove_prefix(end + 2);
    } else {
      text.remove_prefix(end + 1);
    }
  }
  return out;
}

using Row = std::pair<std::string, std::string>;

std::string table(std::string_view title, const std::vector<Row>& rows) {
  if (rows.empty())
    return "";
  std::size_t width = 0;
  for (const Row& row : rows) width = std::max(width, row.first.size());
  width = std::min<std::size_t>(width, 34);
  std::string out = fmt::format("\n{}:\n", title);
  for (const auto& [name, help] : rows) {
    out += fmt::format("  {:<{}}  {}\n", name, width, wrapped(help, width + 4, width + 4));
  }
  return out;
}

std::vector<Row> optionRows(std::span<const Option> options) {
  std::vector<Row> rows;
  for (const Option& option : options) rows.emplace_back(optionNames(option), optionHelp(option));
  return rows;
}

bool inGroup(const Command& command, std::string_view name) {
  return std::ranges::any_of(command.oneOf, [&](const OneOf& group) {
    return group.required && std::ranges::find(group.names, name) != group.names.end();
  });
}

std::string withValue(const Command& command, std::string_view name) {
  const auto option = std::ranges::find(command.options, name, &Option::name);
  const std::string_view value =
      option == command.options.end() ? std::string_view() : option->value;
  return fmt::format("--{}{}{}", name, value.empty() ? "" : " ", value);
}

}  // namespace

std::string optionNames(const Option& option) {
  return fmt::format("{}--{}{}{}", option.letter ? fmt::format("-{}, ", option.letter) : "    ",
                     option.name, option.value.empty() ? "" : " ", option.value);
}

std::string optionHelp(const Option& option) {
  std::string text(option.help);
  if (!option.choices.empty())
    text += fmt::format(": {}", fmt::join(option.choices, ", "));
  if (!option.derived.empty())
    text += fmt::format(" [default the input's name and {}]", option.derived);
  if (!option.initial.empty())
    text += fmt::format(" [default {}]", option.initial);
  if (option.several)
    text += "; may be repeated";
  return text;
}

std::string usageLine(const Command& command) {
  std::string line = fmt::format("volute {}", command.name);
  for (const Positional& positional : command.positionals) {
    const std::string name = fmt::format("{}{}", positional.name, positional.several ? "..." : "");
    line += positional.optional ? fmt::format(" [{}]", name) : " " + name;
  }
  for (const Option& option : command.options) {
    if (option.required)
      line += " " + withValue(command, option.name);
  }
  for (const OneOf& group : command.oneOf) {
    if (!group.required)
      continue;
    std::vector<std::string> names;
    for (const auto name : group.names) names.push_back(withValue(command, name));
    line += fmt::format(" ({})", fmt::join(names, " | "));
  }
  const bool more = std::ranges::any_of(command.options, [&](const Option& option) {
    return !option.required && !inGroup(command, option.name);
  });
  return more ? line + " [options]" : line;
}

std::string overviewText() {
  std::vector<Row> rows;
  for (const Command& command : commands()) rows.emplace_back(command.name, command.summary);
  return "Volute compresses, renders and measures semi-transparent media: fire, smoke, "
         "fog.\n\n"
         "Example:\n"
         "  volute compress fire.npy -o fire.volute --rms 0.003\n"
         "  volute render fire.volute -o fire.mp4\n" +
         table("Commands", rows) + table("Options of every command", optionRows(commonOptions())) +
         "\n'volute help COMMAND' has details. Exit codes: 0 success, 1 failure, 2 wrong usage; a "
         "run that is stopped "
         "ends by its signal (130 or 143 in a shell).\n";
}

std::string helpText(const Command& command) {
  std::string text = command.examples.size() > 1 ? "Examples:\n" : "Example:\n";
  for (const auto example : command.examples) text += fmt::format("  {}\n", example);
  text += fmt::format("\n{}\n", wrapped(command.description, 0, 0));
  text += fmt::format("\nUsage:\n  {}\n", wrapped(usageLine(command), 6, 2));
  std::vector<Row> arguments;
  for (const Positional& positional : command.positionals)
    arguments.emplace_back(positional.name, positional.help);
  return text + table("Arguments", arguments) + table("Options", optionRows(command.options)) +
         table("Options of every command", optionRows(commonOptions()));
}

}  // namespace volute::cli
