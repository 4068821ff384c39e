// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/named_files.hpp"

#include <algorithm>
#include <filesystem>
#include <set>

#include "volute/base/leftovers.hpp"
#include "volute/io/below_folder.hpp"
#include "volute/io/json_file.hpp"

namespace volute::cli {
namespace {

namespace fs = std::filesystem;

/// Texts of a scene or a capture that lead out of its folder. Most texts are names of something
/// else, and all of these lie below the folder if taken as files.
void findOutside(const nlohmann::json& json, const fs::path& folder,
                 std::vector<std::string>& found) {
  if (json.is_structured()) {
    for (const auto& member : json) findOutside(member, folder, found);
  } else if (json.is_string()) {
    const auto& text = json.get_ref<const std::string&>();
    if (!text.empty() && text.find('\0') == text.npos && !isBelowFolder(folder / text, folder) &&
        !fs::path(text).lexically_normal().filename().empty())
      found.push_back(text);
  }
}

}  // namespace

Status checkNamedFiles(const Arguments& arguments, Context& context) {
  for (const std::string& input : arguments.positionals()) {
    const fs::path file(input);
    if (file.extension() != ".json")
      continue;
    const auto json = readJson(input);
    if (!json)
      continue;  // whoever reads it says what is wrong
    std::vector<std::string> outside;
    findOutside(*json, file.has_parent_path() ? file.parent_path() : fs::path("."), outside);
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
    const fs::path path(*target);
    folders.insert(path.has_parent_path() ? path.parent_path() : fs::path("."));
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
