// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "volute/cli/arguments.hpp"
#include "volute/cli/context.hpp"
#include "volute/cli/option.hpp"

namespace volute::cli {

/// One verb of the program. kInvalidArgument from `run` counts as wrong usage (exit 2), other
/// errors as exit 1.
struct Command {
  std::string_view name;
  std::string_view summary;                ///< one line for the overview
  std::vector<std::string_view> examples;  ///< the first opens the help
  std::string_view description;            ///< paragraphs, separated by empty lines
  std::vector<Positional> positionals = {};
  std::vector<Option> options = {};
  std::vector<OneOf> oneOf = {};
  /// Whether several processes that mpirun starts share its work. Then `run` is called on all
  /// ranks, and reads what Context::team says.
  bool ranks = false;
  Status (*run)(const Arguments&, Context&) = nullptr;
};

/// All commands in the order of the overview. A new one is one entry in commands.cpp.
std::span<const Command> commands();

/// Options that every command takes: --threads, --max-memory, --json, --quiet, --verbose, --help,
/// --version.
std::span<const Option> commonOptions();

/// Null when there is none of that name.
const Command* findCommand(std::string_view name);

}  // namespace volute::cli
