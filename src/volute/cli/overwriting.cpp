// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/overwriting.hpp"

#include "volute/io/named_files.hpp"

namespace volute::cli {
namespace {

Status checkOne(std::string_view option, const std::string& output, const std::string& input,
                const std::string& reader) {
  if (!isSameFile(output, input))
    return {};
  return fail(ErrorCode::kInvalidArgument,
              "--{}: {} is read{} and would be replaced; give another name", option, output,
              reader.empty() ? "" : " by " + reader);
}

}  // namespace

Status checkNothingOverwritten(const Command& command, const Arguments& arguments) {
  std::vector<std::pair<std::string_view, std::string>> outputs;
  std::vector<std::string> inputs = arguments.positionals();
  for (const Option& option : command.options) {
    if (option.kind != ValueKind::kFile && option.kind != ValueKind::kOutput)
      continue;
    const auto file = option.several ? std::nullopt : arguments.findGiven<std::string>(option.name);
    if (!file || *file == "-")
      continue;
    if (option.kind == ValueKind::kOutput)
      outputs.emplace_back(option.name, *file);
    else
      inputs.push_back(*file);
  }
  if (outputs.empty())
    return {};
  for (const std::string& input : inputs) {
    for (const auto& [option, output] : outputs) VOLUTE_TRY(checkOne(option, output, input, ""));
    for (const std::string& named : filesNamedIn(input)) {
      for (const auto& [option, output] : outputs)
        VOLUTE_TRY(checkOne(option, output, named, input));
    }
  }
  return {};
}

}  // namespace volute::cli
