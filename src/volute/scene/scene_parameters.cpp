// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// What a person may change about a scene.
#include <algorithm>
#include <cmath>
#include <filesystem>

#include "volute/scene/scene.hpp"

namespace volute {
namespace {

using OrderedJson = nlohmann::ordered_json;
using ParameterKind = Parameter::Kind;
using Group = ParameterGroup;

std::vector<double> numbers(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

std::vector<double> numbers(const Rgb& c) {
  return {c[0], c[1], c[2]};
}

std::string nameOfFile(const std::string& file) {
  return std::filesystem::path(file).filename().string();
}

void addLights(std::vector<Parameter>& out, const OrderedJson& lights) {
  for (std::size_t i = 0; i < lights.size(); ++i) {
    const std::string kind = lights[i].at("kind");
    Group group(out, lights.size() == 1 ? kind : fmt::format("{} {}", kind, i + 1),
                fmt::format("/lights/{}", i));
    const auto vector = [&](const char* key, std::vector<double> usual) {
      return lights[i].value(key, std::move(usual));
    };
    if (kind == "sun") {
      group.add("direction", "direction", ParameterKind::kDirection, vector("direction", {0, 0, -1}));
      group.add("irradiance", "radiance", ParameterKind::kColor, vector("radiance", {1, 1, 1})).help =
          "what arrives on a surface that faces the sun";
    } else if (kind == "ambient") {
      group.add("radiance", "radiance", ParameterKind::kColor, vector("radiance", {0, 0, 0})).help =
          "from everywhere";
    } else {
      group.add("position", "position", ParameterKind::kPoint, vector("position", {0, 0, 0})).unit = "m";
      group.add("target", "target", ParameterKind::kPoint, vector("target", {0, 0, 0})).unit = "m";
      group.range("cone", "angle", lights[i].value("angle", 60.0), 1, 179, "degrees").help =
          "from side to side";
      group.add("intensity", "intensity", ParameterKind::kColor, vector("intensity", {1, 1, 1})).help =
          "power per solid angle";
    }
  }
}

void addSigns(std::vector<Parameter>& out, const OrderedJson& signs, const SceneDescription& scene) {
  for (std::size_t i = 0; i < scene.signs.size(); ++i) {
    const Sign& sign = scene.signs[i];
    Group group(out, "sign: " + (sign.name.empty() ? fmt::format("{}", i + 1) : sign.name),
                fmt::format("/signs/{}", i));
    group.add("position", "position", ParameterKind::kPoint, numbers(sign.position)).unit = "m";
    group.add("normal", "normal", ParameterKind::kDirection, numbers(sign.normal));
    group.add("emits light", "emitting", ParameterKind::kFlag,
              {signs[i].value("emitting", false) ? 1.0 : 0.0});
    // A string's assignment from a literal is what GCC 12 warns of in vain (bug 105651).
    group.range("C", "C", sign.c, 1, 10).help = std::string("no longer seen at this optical depth");
    group.range("width", "size/0", sign.width, 0.05, 3, "m");
    group.range("height", "size/1", sign.height, 0.05, 3, "m");
  }
}

Status checkValue(const Parameter& parameter, const std::vector<double>& value) {
  const bool finite = std::ranges::all_of(value, [](double v) { return std::isfinite(v); });
  if (value.size() == parameter.value.size() && finite)
    return {};
  return fail(ErrorCode::kInvalidArgument, "{}: expected {} finite numbers", parameter.path,
              parameter.value.size());
}

OrderedJson jsonOf(const Parameter& parameter, const std::vector<double>& value) {
  switch (parameter.kind) {
    case ParameterKind::kFlag:
      return value.front() != 0;
    case ParameterKind::kInteger:
      return static_cast<int>(std::lround(value.front()));
    case ParameterKind::kChoice:
      return parameter.choices.at(
          static_cast<std::size_t>(std::clamp(std::round(value.front()), 0.0, parameter.most)));
    case ParameterKind::kNumber:
      return value.front();
    default:
      return value;
  }
}

}  // namespace

std::vector<Parameter> Scene::parameters() const {
  std::vector<Parameter> out;
  for (std::size_t i = 0; i < media_.size(); ++i) {
    const MediumEntry& entry = description_.media[i];
    const MediumInfo& info = media_[i]->info();
    entry.kind->addParameters({out, fmt::format("{}: {}", info.kind, nameOfFile(info.file)), entry.path},
                              json_.at(OrderedJson::json_pointer(entry.path)), *media_[i],
                              !description_.lights.suns.empty());
  }
  addLights(out, json_.value("lights", OrderedJson::array()));
  addSigns(out, json_.value("signs", OrderedJson::array()), description_);
  Group group(out, "background", "");
  group.add("radiance", "background", ParameterKind::kColor, numbers(description_.background)).help =
      "behind everything";
  return out;
}

Result<OrderedJson> Scene::with(const std::string& path, const std::vector<double>& value) const {
  const auto all = parameters();
  const auto found = std::ranges::find(all, path, &Parameter::path);
  if (found == all.end())
    return fail(ErrorCode::kInvalidArgument, "{}: the scene has no such parameter", path);
  VOLUTE_TRY(checkValue(*found, value));
  OrderedJson json = json_;
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
    if (!entry.kind->shares(key))
      continue;
    for (const MediumEntry& other : description_.media) {
      if (other.kind->name() == entry.kind->name())
        json[OrderedJson::json_pointer(other.path)][key] = put;
    }
    return json;
  }
  if (path.find("/size/") != std::string::npos) {
    OrderedJson& size = json[pointer.parent_pointer()];
    if (size.is_null())
      size = {Sign{}.width, Sign{}.height};
    size[key == "0" ? 0 : 1] = put;
    return json;
  }
  if (path.starts_with("/signs/") && key == "emitting")
    json[pointer.parent_pointer()].erase("C");
  json[pointer] = put;
  return json;
}

}  // namespace volute
