// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/named_files.hpp"

#include <algorithm>
#include <filesystem>
#include <set>

#include "volute/base/leftovers.hpp"
#include "volute/base/file_name.hpp"
#include "volute/io/named_files.hpp"

namespace volute::cli {
namespace {

namespace fs = std::filesystem;

}  // namespace

Status checkNamedFiles(const Arguments& arguments, Context& context) {
  for (const std::string& input : arguments.positionals()) {
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
  std::set<fs::path> folders;
  for (const Option& option : command.options) {
    if (option.kind != ValueKind::kOutput && option.name != "output")
      continue;
    const auto target = option.several ? std::nullopt
                                       : arguments.findGiven<std::string>(option.name);
    if (!target || *target == "-")
      continue;
    folders.insert(folderOf(*target));
  }
  for (const fs::path& folder : folders) {
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
