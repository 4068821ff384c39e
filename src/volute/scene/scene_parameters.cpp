// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// What a person may change about a scene.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "volute/scene/scene.hpp"

namespace volute {
namespace {

using OrderedJson = nlohmann::ordered_json;

std::string nameOfFile(const std::string& file) {
  return std::filesystem::path(file).filename().string();
}

MediumFacts factsOf(const MediumInfo& info, bool suns) {
  return {.frames = static_cast<int>(info.times.size()),
          .seconds = std::abs(info.times.back() - info.times.front()),
          .bounds = info.fileBounds,
          .suns = suns};
}

/// Of an entry of "lights", "signs" or "clip".
const FieldTable& tableOf(std::string_view list, const OrderedJson& entry) {
  if (list == "signs")
    return signFields();
  return **std::ranges::find(list == "clip" ? clipTables() : lightTables(),
                             entry.at("kind").get<std::string>(), &FieldTable::kind);
}

/// Of the entries of "lights", "signs" or "clip".
void addList(std::vector<Parameter>& out, const OrderedJson& json, const std::string& list,
             const Box3& bounds) {
  const OrderedJson entries = json.value(list, OrderedJson::array());
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const FieldTable& table = tableOf(list, entries[i]);
    const std::string number = fmt::format("{}", i + 1);
    std::string title(table.name);
    std::ranges::replace(title, '_', ' ');
    const std::string name = entries[i].value("name", "");
    if (list == "signs")
      title += ": " + (name.empty() ? number : name);
    else if (entries.size() > 1)
      title += " " + number;
    ParameterGroup group(out, title, fmt::format("/{}/{}", list, i));
    const auto object = table.make();
    if (readFields(table, nlohmann::json(entries[i]), {}, object.get()))
      addSliders(group, table, object.get(), {.bounds = bounds});
  }
}

/// The end of a box that was moved stays beside the other.
void keepApart(OrderedJson& box, const std::string& moved) {
  constexpr double kThin = 1e-3;  // [m]
  const bool first = moved == "min";
  const OrderedJson& other = box.at(first ? "max" : "min");
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double rest = other[axis].get<double>(), own = box[moved][axis].get<double>();
    const double apart = std::max(kThin, 1e-9 * std::abs(rest));
    box[moved][axis] = first ? std::min(own, rest - apart) : std::max(own, rest + apart);
  }
}

Status checkValue(const Parameter& parameter, const std::vector<double>& value) {
  const bool finite = std::ranges::all_of(value, [](double v) { return std::isfinite(v); });
  if (value.size() == parameter.value.size() && finite)
    return {};
  return fail(ErrorCode::kInvalidArgument, "{}: expected {} finite numbers", parameter.path,
              parameter.value.size());
}

}  // namespace

std::vector<Parameter> Scene::parameters() const {
  std::vector<Parameter> out;
  for (std::size_t i = 0; i < media_.size(); ++i) {
    const MediumEntry& entry = description_.media[i];
    const MediumInfo& info = media_[i]->info();
    ParameterGroup group(out, fmt::format("{}: {}", info.kind, nameOfFile(info.file)), entry.path);
    entry.kind->addParameters(group, json_->at(OrderedJson::json_pointer(entry.path)), *media_[i],
                              factsOf(info, !description_.lights.suns.empty()));
  }
  for (const char* list : {"lights", "signs", "clip"}) addList(out, *json_, list, bounds());
  constexpr std::string_view kScattering[] = {"single", "multiple"};
  if (!description_.lights.lamps.empty() || !description_.lights.ambient.isZero(0))
    ParameterGroup(out, "light", "")
        .choice("scattering", "scattering", kScattering,
                kScattering[description_.lights.multiple ? 1 : 0])
        .help = "how often light is scattered; multiple is an approximation";
  const Rgb& behind = description_.background;
  ParameterGroup(out, "background", "")
      .add("radiance", "background", Parameter::Kind::kColor, {behind[0], behind[1], behind[2]})
      .help = "behind everything";
  return out;
}

Result<OrderedJson> Scene::with(const std::string& path, const std::vector<double>& value) const {
  const auto all = parameters();
  const auto found = std::ranges::find(all, path, &Parameter::path);
  if (found == all.end())
    return fail(ErrorCode::kInvalidArgument, "{}: the scene has no such parameter", path);
  VOLUTE_TRY(checkValue(*found, value));
  OrderedJson json = *json_;
  const OrderedJson put = jsonOf(*found, value);
  const OrderedJson::json_pointer pointer(path);
  const std::string key = pointer.back();
  for (std::size_t i = 0; i < media_.size(); ++i) {
    const MediumEntry& entry = description_.media[i];
    if (!path.starts_with(entry.path + "/"))
      continue;
    OrderedJson& own = json[OrderedJson::json_pointer(entry.path)];
    if (entry.kind->setParameter(own, *media_[i], path.substr(entry.path.size() + 1), put, value))
      return json;
    if (!entry.kind->shares(key)) {
      putSlider(json, entry.kind->fields(), entry.path, *found, value);
      return json;
    }
    for (const MediumEntry& other : description_.media) {
      if (other.kind->name() == entry.kind->name())
        json[OrderedJson::json_pointer(other.path)][key] = put;
    }
    return json;
  }
  for (const char* list : {"lights", "signs", "clip"}) {
    const std::string begin = fmt::format("/{}/", list);
    if (!path.starts_with(begin))
      continue;
    const std::string owner = path.substr(0, path.find('/', begin.size()));
    OrderedJson& entry = json[OrderedJson::json_pointer(owner)];
    putSlider(json, tableOf(list, entry), owner, *found, value);
    if (begin == "/clip/" && (key == "min" || key == "max"))
      keepApart(entry, key);
    if (begin == "/signs/" && key == "emitting")
      entry.erase("C");
    return json;
  }
  json[pointer] = put;
  return json;
}

}  // namespace volute
