// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>
#include <string>

#include "volute/base/program.hpp"
#include "volute/cli/arguments.hpp"
#include "volute/cli/command.hpp"

namespace volute::cli {

/// Inputs that come through pipes: "-", /dev/stdin, and <(...), which shells name /dev/fd/N. As
/// long as this lives they are files, since readers go back and forth in them.
class PipedInputs {
 public:
  /// Puts a file's name in the place of each pipe. What stands for the command itself (its
  /// positionals) gets a name whose end says what is in it, as all readers choose by that; an
  /// option's file keeps the pipe's.
  [[nodiscard]] Status take(const Command& command, Arguments& arguments, Context& context);

 private:
  [[nodiscard]] Result<std::string> fileOf(const std::string& pipe, Context& context);

  std::optional<ScratchFolder> folder_;
  std::vector<std::string> taken_;
};

}  // namespace volute::cli
