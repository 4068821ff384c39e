// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/field_sliders.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace volute {
namespace {

using Kind = Parameter::Kind;

Kind sliderKind(FieldType type) {
  switch (type) {
    case FieldType::kInteger:
      return Kind::kInteger;
    case FieldType::kFlag:
      return Kind::kFlag;
    case FieldType::kChoice:
      return Kind::kChoice;
    case FieldType::kColor:
      return Kind::kColor;
    case FieldType::kPoint:
      return Kind::kPoint;
    case FieldType::kDirection:
      return Kind::kDirection;
    default:
      return Kind::kNumber;
  }
}

std::vector<double> sliderNumbers(const FieldRow& field, const FieldValue& value) {
  if (value.is_array())
    return value.get<std::vector<double>>();
  if (value.is_boolean())
    return {value.get<bool>() ? 1.0 : 0.0};
  if (value.is_number())
    return {value.get<double>()};
  const auto found = std::ranges::find(field.choices, value.get<std::string>());
  return {static_cast<double>(found - field.choices.begin())};
}

/// The row's limits, wide enough for the value.
void setLimits(Parameter& made, const FieldRow& field, double value) {
  const FieldSlider& slider = field.slider;
  const double least = std::isfinite(slider.least) ? slider.least : field.least;
  const double most = std::isfinite(slider.most) ? slider.most : field.most;
  if (std::isfinite(least))
    made.least = std::min(least, value);
  if (std::isfinite(most))
    made.most = std::max({most, value, slider.room > 1 ? slider.room * value : value});
  made.logarithmic = slider.logarithmic;
}

/// "width|height": two sliders of one row, for its numbers.
void addPair(ParameterGroup& group, const FieldRow& field, const std::string& key,
             const FieldValue& value) {
  FieldRow one = field;
  one.type = FieldType::kNumber;
  std::string_view labels = field.slider.label;
  for (std::size_t i = 0; i < value.size(); ++i) {
    const std::size_t bar = std::min(labels.find('|'), labels.size());
    one.slider.label = labels.substr(0, bar);
    group.add(one, fmt::format("{}/{}", key, i), value[i]);
    labels.remove_prefix(std::min(bar + 1, labels.size()));
  }
}

}  // namespace

Parameter& ParameterGroup::add(const std::string& name, const std::string& key, Kind kind,
                               std::vector<double> value) {
  out_.push_back({name_, name, path_ + "/" + key, kind, std::move(value)});
  out_.back().section = section_;
  return out_.back();
}

Parameter& ParameterGroup::add(const FieldRow& field, const std::string& key,
                               const FieldValue& value) {
  Parameter& made = add(std::string(field.slider.label), key, sliderKind(field.type),
                        sliderNumbers(field, value));
  const std::string_view unit = field.slider.unit.empty() ? field.unit : field.slider.unit;
  made.unit = unit.starts_with("1/") ? unit.substr(1) : unit;
  made.help = field.help;
  if (made.kind == Kind::kNumber || made.kind == Kind::kInteger)
    setLimits(made, field, made.value.front());
  if (made.kind == Kind::kChoice) {
    made.choices = {field.choices.begin(), field.choices.end()};
    made.most = static_cast<double>(made.choices.size()) - 1;
  }
  return made;
}

Parameter& ParameterGroup::choice(const std::string& name, const std::string& key,
                                  std::span<const std::string_view> choices,
                                  std::string_view value) {
  const auto found = std::ranges::find(choices, value);
  const auto place = found == choices.end() ? 0 : found - choices.begin();
  Parameter& made = add(name, key, Kind::kChoice, {static_cast<double>(place)});
  made.most = static_cast<double>(choices.size()) - 1;
  made.choices = {choices.begin(), choices.end()};
  return made;
}

Parameter& ParameterGroup::point(const std::string& name, const std::string& key, const Vec3& value,
                                 const char* unit, double step) {
  Parameter& made = add(name, key, Kind::kPoint, {value.x(), value.y(), value.z()});
  made.unit = std::string(unit);  // GCC 12 warns of the plain assignment
  made.step = step;
  return made;
}

void addSliders(ParameterGroup& group, const FieldTable& table, const void* object,
                const MediumFacts& facts, const std::string& prefix, std::string_view section) {
  for (const FieldRow& field : table.fields) {
    const FieldSlider& slider = field.slider;
    const void* inner = field.access.find ? field.access.find(object) : object;
    group.section(section.empty() ? slider.section : section);
    if (slider.custom) {
      slider.custom(group, inner, facts);
    } else if (field.type == FieldType::kObject && !slider.section.empty() && inner) {
      addSliders(group, *field.table, inner, facts, fmt::format("{}{}/", prefix, field.name),
                 slider.section);
    } else if (!slider.label.empty() && (!slider.shown || slider.shown(object, facts))) {
      const std::string key = fmt::format("{}{}", prefix, field.name);
      const FieldValue value = field.access.get(field, object);
      if (slider.label.find('|') != std::string_view::npos) {
        addPair(group, field, key, value);
        continue;
      }
      Parameter& made = group.add(field, key, value);
      if (slider.step)
        made.step = slider.step(object, facts);
    }
  }
  group.section("");
}

nlohmann::ordered_json jsonOf(const Parameter& parameter, const std::vector<double>& value) {
  switch (parameter.kind) {
    case Kind::kFlag:
      return value.front() != 0;
    case Kind::kInteger:
      return static_cast<int>(std::lround(value.front()));
    case Kind::kChoice:
      return parameter.choices.at(
          static_cast<std::size_t>(std::clamp(std::round(value.front()), 0.0, parameter.most)));
    case Kind::kNumber:
      return value.front();
    default:
      return value;
  }
}

void putSlider(nlohmann::ordered_json& json, const FieldTable& table, const std::string& owner,
               const Parameter& parameter, const std::vector<double>& value) {
  const nlohmann::ordered_json::json_pointer pointer(parameter.path), object(owner);
  const std::string key = parameter.path.substr(owner.size() + 1);
  const std::string name = key.substr(0, key.find('/'));
  const FieldRow* field = table.find(name);
  nlohmann::ordered_json& members = json[object];
  if (field && field->type == FieldType::kNumbers && key != name && !members.contains(name))
    members[name] = nlohmann::ordered_json::parse(field->access.get(*field, table.usual).dump());
  json[pointer] = jsonOf(parameter, value);
}

}  // namespace volute
