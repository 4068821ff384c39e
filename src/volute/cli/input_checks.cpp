// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/input_checks.hpp"

#include <set>

#include "volute/base/file_name.hpp"
#include "volute/base/leftovers.hpp"
#include "volute/base/output_place.hpp"
#include "volute/base/read_files.hpp"
#include "volute/io/named_files.hpp"
#include "volute/io/output_names.hpp"

namespace volute::cli {

Status checkNothingOverwritten(const Command& command, const Arguments& arguments) {
  std::vector<std::pair<std::string_view, std::string>> outputs;
  std::vector<std::string> inputs = arguments.positionals();
  for (const Option& option : command.options) {
    if (option.kind != ValueKind::kFile && option.kind != ValueKind::kOutput)
      continue;
    const bool isOutput = option.kind == ValueKind::kOutput;  // named by default, too
    const auto file = option.several ? std::nullopt
                      : isOutput     ? arguments.find<std::string>(option.name)
                                     : arguments.findGiven<std::string>(option.name);
    if (!file || *file == "-")
      continue;
    if (isOutput)
      outputs.emplace_back(option.name, *file);
    else
      inputs.push_back(*file);
  }
  if (outputs.empty())
    return {};
  OutputNames names;
  for (const auto& [option, output] : outputs) {
    VOLUTE_TRY(names.add(output, fmt::format("--{}", option)));
    if (option == "report")  // its page
      VOLUTE_TRY(names.add(std::filesystem::path(output).replace_extension(".html").string(),
                           "the page of --report"));
  }
  for (const auto& [option, output] : outputs)
    VOLUTE_TRY(checkReplacesNothing(output, inputs, option));
  // What other files name, a case's slices or a mesh's pieces, is known when it is read.
  std::vector<std::filesystem::path> targets;
  for (const auto& [option, output] : outputs) targets.emplace_back(output);
  protectWhatIsRead(std::move(targets));
  return {};
}

Status checkNamedFiles(const Command& command, const Arguments& arguments, Context& context) {
  std::vector<std::string> inputs = arguments.positionals();
  for (const Option& option : command.options) {
    if (option.kind != ValueKind::kFile || option.several)
      continue;
    if (const auto file = arguments.findGiven<std::string>(option.name))
      inputs.push_back(*file);
  }
  for (const std::string& input : inputs) {
    const auto outside = namesOutside(input);
    if (outside.empty())
      continue;
    const std::string more =
        outside.size() > 1 ? fmt::format(" and {} more", outside.size() - 1) : "";
    if (arguments.flag("untrusted")) {
      return fail(ErrorCode::kInvalidData,
                  "{}: names '{}'{}, outside of its folder; --untrusted refuses that", input,
                  outside.front(), more);
    }
    context.progress.remark(
        fmt::format("{}: names '{}'{}, outside of its folder (--untrusted refuses that)", input,
                    outside.front(), more));
  }
  return {};
}

void remarkOnLeftovers(const Command& command, const Arguments& arguments, Context& context) {
  std::set<std::filesystem::path> folders;
  for (const Option& option : command.options) {
    if (option.kind != ValueKind::kOutput && option.name != "output")
      continue;
    const auto target =
        option.several ? std::nullopt : arguments.findGiven<std::string>(option.name);
    if (!target || *target == "-")
      continue;
    const auto place = outputPlace(*target, *target);
    folders.insert(folderOf(place ? *place : std::filesystem::path(*target)));
  }
  for (const std::filesystem::path& folder : folders) {
    const auto parts = leftoversIn(folder);
    if (parts.empty())
      continue;
    const std::string more = parts.size() > 1 ? fmt::format(" and {} more", parts.size() - 1) : "";
    context.progress.remark(
        fmt::format("{}{}: left by runs that were killed; unless another machine writes there, "
                    "delete them: rm -r '{}'/.*.part*",
                    parts.front().string(), more, folder.string()));
  }
}

}  // namespace volute::cli
