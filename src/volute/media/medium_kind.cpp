// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/medium_kind.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <regex>

#include "volute/media/ray_sight.hpp"
#include "volute/report/report.hpp"

namespace volute {

using OrderedJson = nlohmann::ordered_json;

OrderedJson MediumSnapshot::counts() const {
  return OrderedJson::object();
}

OrderedJson SceneMedium::counts() const {
  return OrderedJson::object();
}

void addCounts(OrderedJson& sum, const OrderedJson& more) {
  for (const auto& [name, value] : more.items()) {
    OrderedJson& to = sum[name];
    if (value.is_object())
      addCounts(to, value);
    else if (value.is_number_float())
      to = (to.is_null() ? 0.0 : to.get<double>()) + value.get<double>();
    else
      to = (to.is_null() ? 0 : to.get<std::uint64_t>()) + value.get<std::uint64_t>();
  }
}

std::vector<OrderedJson> MediumKind::alternatives(const OrderedJson& entry) const {
  (void)entry;
  return {};
}

std::optional<int> sceneVersionOf(const nlohmann::json& format) {
  for (int version = 1; version <= kSceneVersion; ++version) {
    if (format == fmt::format("volute-scene-{}", version))
      return version;
  }
  return std::nullopt;
}

OrderedJson MediumKind::sceneOf(const std::string& name) const {
  return {{"format", kSceneFormat},
          {"media", OrderedJson::array({{{"kind", this->name()}, {"file", name}}})}};
}

/// Patterns are about the ends of names, and std::regex takes stack for every character.
bool MediumKind::claims(const nlohmann::json& entry) const {
  constexpr std::size_t kEnd = 64;
  return std::ranges::all_of(fields().fields, [&](const FieldRow& field) {
    if (field.pattern.empty())
      return true;
    const auto found = entry.find(field.name);
    const bool said = found != entry.end() && found->is_string();
    const std::string name = said ? found->get<std::string>() : "";
    return std::regex_search(name.substr(name.size() - std::min(name.size(), kEnd)),
                             std::regex(std::string(field.pattern)));
  });
}

void MediumKind::addParameters(ParameterGroup& group, const OrderedJson& entry,
                               const SceneMedium& /*medium*/, MediumFacts facts) const {
  const auto object = fields().make();
  if (readFields(fields(), nlohmann::json(entry), {}, object.get()))
    addSliders(group, fields(), object.get(), facts);
}

Result<FileDescription> MediumKind::describe(const std::string& path, const DescribeRequest&,
                                             Reading&) const {
  FileDescription described;
  described.report.add("file", path).add("kind", name());
  return described;
}

Result<std::unique_ptr<SightField>> SceneMedium::sight(Reading&) {
  return std::make_unique<RaySight>(shared_from_this());
}

std::vector<const MediumKind*>& mediumKinds() {
  static std::vector<const MediumKind*> kinds;
  return kinds;
}

void registerMedium(const MediumKind& kind) {
  mediumKinds().push_back(&kind);
}

Result<const MediumKind*> mediumKindOf(const nlohmann::json& entry, std::string_view list,
                                       const std::string& file, const std::string& path) {
  std::vector<std::string_view> names;
  const MediumKind* only = nullptr;
  for (const MediumKind* kind : mediumKinds()) {
    if (kind->list() != list)
      continue;
    only = kind;
    if (std::ranges::find(names, kind->name()) == names.end())
      names.push_back(kind->name());
  }
  if (names.size() == 1 && list != "media")
    return only;
  std::string expected;
  for (std::size_t i = 0; i < names.size(); ++i) {
    expected += fmt::format("{}{}", i == 0 ? "" : i + 1 == names.size() ? " or " : ", ", names[i]);
  }
  if (!entry.is_object() || !entry.contains("kind") || !entry["kind"].is_string())
    return fail(ErrorCode::kInvalidData, "{}: {}/kind: expected {}", file, path, expected);
  const auto name = entry["kind"].get<std::string>();
  for (const MediumKind* kind : mediumKinds()) {
    if (kind->list() == list && kind->name() == name && kind->claims(entry))
      return kind;
  }
  return fail(ErrorCode::kInvalidData, "{}: {}/kind: '{}' is unknown; expected {}", file, path,
              name, expected);
}

const MediumKind* mediumKindOf(const std::string& path, bool assuming) {
  for (const MediumKind* kind : mediumKinds()) {
    if (kind->opens(path) && (assuming || !kind->assumes()))
      return kind;
  }
  return nullptr;
}

}  // namespace volute
