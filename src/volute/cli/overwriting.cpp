// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/overwriting.hpp"

#include <filesystem>

#include "volute/io/json_file.hpp"

namespace volute::cli {
namespace {

namespace fs = std::filesystem;

void addTexts(const nlohmann::json& json, const fs::path& folder, std::vector<std::string>& names) {
  if (json.is_string()) {
    if (const auto& text = json.get_ref<const std::string&>(); !text.empty())
      names.push_back((folder / text).string());
    return;
  }
  for (const auto& member : json) {
    if (member.is_string() || member.is_structured())
      addTexts(member, folder, names);
  }
}

/// What a scene or a capture may name. Whatever is wrong with it is said by those who read it.
std::vector<std::string> namedIn(const std::string& file) {
  std::vector<std::string> names;
  if (fs::path(file).extension() != ".json")
    return names;
  if (const auto json = readJson(file))
    addTexts(*json, fs::path(file).parent_path(), names);
  return names;
}

Status checkOne(std::string_view option, const std::string& output, const std::string& input,
                const std::string& reader) {
  if (!isSameFile(output, input))
    return {};
  return fail(ErrorCode::kInvalidArgument,
              "--{}: {} is read{} and would be replaced; give another name", option, output,
              reader.empty() ? "" : " by " + reader);
}

}  // namespace

std::string derivedOutput(const std::string& input, std::string_view end) {
  fs::path path = fs::path(input).lexically_normal();
  if (path.filename().empty())
    path = path.parent_path();  // a folder with its slash
  std::string stem = path.stem().string();
  if (const auto number = stem.find_first_of("%#"); number != stem.npos)
    stem.resize(number);
  while (!stem.empty() && (stem.back() == '_' || stem.back() == '.' || stem.back() == '-'))
    stem.pop_back();
  if (stem.empty())
    stem = "volute";
  std::error_code ignored;
  for (int i = 1;; ++i) {
    const std::string name = fmt::format("{}{}{}", stem, i == 1 ? "" : fmt::format("_{}", i), end);
    if (!fs::exists(fs::symlink_status(name, ignored)))
      return name;
  }
}

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
    for (const std::string& named : namedIn(input)) {
      for (const auto& [option, output] : outputs)
        VOLUTE_TRY(checkOne(option, output, named, input));
    }
  }
  return {};
}

}  // namespace volute::cli
