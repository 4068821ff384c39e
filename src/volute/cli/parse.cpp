// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/parse.hpp"

#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>

#include "volute/base/suggest.hpp"

namespace volute::cli {
namespace {

struct Entry {
  const Option* option;
  CLI::Option* handle;
  const Option* instead;  ///< Option::instead; null: none
};

std::vector<std::string_view> namesOf(const Option& option) {
  std::vector<std::string_view> names{option.name};
  names.insert(names.end(), option.aliases.begin(), option.aliases.end());
  return names;
}

/// CLI11 finds the options and their values in the words; what they mean is checked here, so that
/// each error is one sentence in our own words.
std::vector<Entry> addOptions(CLI::App& app, std::span<const Option> options) {
  std::vector<Entry> entries;
  for (const Option& option : options) {
    std::string names = fmt::format("--{}", fmt::join(namesOf(option), ",--"));
    if (option.letter != 0)
      names = fmt::format("-{},{}", option.letter, names);
    CLI::Option* handle =
        option.kind == ValueKind::kFlag ? app.add_flag(names) : app.add_option(names);
    handle->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    const auto instead = std::ranges::find(options, option.instead, &Option::name);
    entries.push_back({&option, handle, instead == options.end() ? nullptr : &*instead});
  }
  return entries;
}

Status parseWords(CLI::App& app, std::vector<std::string> words) {
  std::ranges::reverse(words);
  try {
    app.parse(words);
  } catch (const CLI::ArgumentMismatch& error) {
    const std::string what = error.what();
    return fail(ErrorCode::kInvalidArgument, "{} needs a value", what.substr(0, what.find(':')));
  } catch (const CLI::Error& error) {
    return fail(ErrorCode::kInvalidArgument, "{}", error.what());
  }
  return {};
}

tl::unexpected<Error> unknownOption(const std::string& word, std::span<const Entry> entries) {
  const std::string name = word.substr(0, word.find('='));
  std::vector<std::string_view> names;
  for (const Entry& entry : entries) names.push_back(entry.option->name);
  const auto near = nearest(std::string_view(name).substr(name.find_first_not_of('-')), names);
  if (near.empty())
    return fail(ErrorCode::kInvalidArgument, "unknown option {}", name);
  return fail(ErrorCode::kInvalidArgument, "unknown option {}; did you mean --{}?", name, near);
}

Status takeOption(const Entry& entry, Arguments& arguments) {
  const Option& option = *entry.option;
  if (option.several) {
    arguments.set(option.name, entry.handle->results(), entry.handle->count() > 0);
    return {};
  }
  if (entry.handle->count() > 1 && option.kind != ValueKind::kFlag) {
    return fail(ErrorCode::kInvalidArgument, "--{} is given {} times; expected once",
                fmt::join(namesOf(option), ", also called --"), entry.handle->count());
  }
  const bool given = entry.handle->count() > 0;
  if (!given && option.initial.empty())
    return {};
  const std::string text = given && option.kind != ValueKind::kFlag
                               ? entry.handle->results().front()
                               : std::string(option.initial);
  if (given && entry.instead &&
      std::ranges::find(entry.instead->choices, text) != entry.instead->choices.end()) {
    if (arguments.given(entry.instead->name)) {
      return fail(ErrorCode::kInvalidArgument, "--{} {} and --{} say the same; omit one",
                  option.name, text, entry.instead->name);
    }
    arguments.set(entry.instead->name, text, true);
    return {};
  }
  auto value = parseValue(option, text);
  if (!value)
    return fail(ErrorCode::kInvalidArgument, "--{}: {}", option.name, value.error().message);
  arguments.set(option.name, std::move(*value), given);
  return {};
}

Status checkPositionals(const Command& command, const Arguments& arguments) {
  const auto& words = arguments.positionals();
  for (std::size_t i = words.size(); i < command.positionals.size(); ++i) {
    if (command.positionals[i].optional)
      continue;
    return fail(ErrorCode::kInvalidArgument, "{} is missing: {}", command.positionals[i].name,
                command.positionals[i].help);
  }
  const bool several = !command.positionals.empty() && command.positionals.back().several;
  if (words.size() > command.positionals.size() && !several) {
    return fail(ErrorCode::kInvalidArgument, "'{}' is one argument too many",
                words[command.positionals.size()]);
  }
  return {};
}

std::string listed(const std::vector<std::string_view>& names) {
  return fmt::format("--{}", fmt::join(names, ", --"));
}

Status checkRequirements(const Command& command, const Arguments& arguments) {
  for (const Option& option : command.options) {
    if (option.required && !arguments.given(option.name)) {
      return fail(ErrorCode::kInvalidArgument, "--{} {} is missing: {}", option.name, option.value,
                  option.help);
    }
  }
  for (const Option& option : command.options) {
    if (arguments.given(option.name) && !option.beside.empty() && !arguments.given(option.beside)) {
      return fail(ErrorCode::kInvalidArgument,
                  "--{0} has no effect without --{1}; add --{1} or omit it", option.name,
                  option.beside);
    }
  }
  for (const OneOf& group : command.oneOf) {
    const auto given =
        std::ranges::count_if(group.names, [&](auto name) { return arguments.given(name); });
    if (given > 1) {
      return fail(ErrorCode::kInvalidArgument, "{} of {} are given; expected one", given,
                  listed(group.names));
    }
    if (given == 0 && group.required) {
      return fail(ErrorCode::kInvalidArgument, "one of {} is missing", listed(group.names));
    }
  }
  return {};
}

}  // namespace

Result<Arguments> parseArguments(const Command& command, const std::vector<std::string>& words) {
  CLI::App app;
  app.set_help_flag();
  app.allow_extras();
  auto entries = addOptions(app, command.options);
  std::ranges::copy(addOptions(app, commonOptions()), std::back_inserter(entries));
  const auto separator = std::ranges::find(words, "--");
  VOLUTE_TRY(parseWords(app, {words.begin(), separator}));

  Arguments arguments;
  arguments.setOptions(command.options);
  for (const auto& word : app.remaining()) {
    if (word.size() > 1 && word.front() == '-')
      return unknownOption(word, entries);
    arguments.addPositional(word);
  }
  if (separator != words.end()) {
    std::for_each(separator + 1, words.end(),
                  [&](const auto& word) { arguments.addPositional(word); });
  }
  for (const Entry& entry : entries) VOLUTE_TRY(takeOption(entry, arguments));
  if (arguments.flag("help") || arguments.flag("version"))
    return arguments;
  VOLUTE_TRY(checkPositionals(command, arguments));
  VOLUTE_TRY(checkRequirements(command, arguments));
  return arguments;
}

SettingText optionsOf(const Command& command) {
  return [&command](const std::string& setting, const std::string& value) -> std::string {
    if (setting == "resample")  // another command's doing
      return "volute resample";
    std::string option = setting;
    std::ranges::replace(option, '_', '-');
    const std::string name = option.substr(0, option.find('['));
    const auto has = [&](std::span<const Option> options) {
      return std::ranges::find(options, name, &Option::name) != options.end();
    };
    if (!has(command.options) && !has(commonOptions()))
      return "";
    return value.empty() ? "--" + option : fmt::format("--{} {}", option, value);
  };
}

Result<std::size_t> findCommandWord(const std::vector<std::string>& words) {
  CLI::App app;
  app.set_help_flag();
  app.prefix_command();
  const auto entries = addOptions(app, commonOptions());
  VOLUTE_TRY(parseWords(app, words));
  const auto rest = app.remaining();
  if (!rest.empty() && rest.front().starts_with('-'))
    return unknownOption(rest.front(), entries);
  return words.size() - rest.size();
}

}  // namespace volute::cli
