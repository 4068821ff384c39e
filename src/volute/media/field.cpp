// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/field.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "volute/base/suggest.hpp"
#include "volute/io/json_values.hpp"
#include "volute/media/medium_kind.hpp"

namespace volute {
namespace {

using enum FieldType;

std::string numberWord(int count) {
  constexpr std::string_view kNumberWords[] = {"", "one", "two", "three"};
  return count < 4 ? std::string(kNumberWords[count]) : fmt::format("{}", count);
}

bool isNumber(const FieldValue& value, bool whole) {
  return whole ? value.is_number_integer()
               : value.is_number() && std::isfinite(value.get<double>());
}

/// Numbers beyond this mean that something is not there, as netCDF's fill value (9.97e36) does.
constexpr double kLargest = 1e30;

bool holds(const FieldRow& field, double value) {
  return field.holds(value) && std::abs(value) <= kLargest;
}

/// How many numbers a value of this type has: {fewest, most}.
std::pair<std::size_t, std::size_t> countsOf(const FieldRow& field) {
  const auto count = static_cast<std::size_t>(field.count);
  if (count == 0)
    return {0, std::numeric_limits<std::size_t>::max()};
  return {field.fewest > 0 ? static_cast<std::size_t>(field.fewest) : count, count};
}

/// What is wrong, and where in the value: "[2]".
struct FieldFault {
  std::string message;
  std::string_view expected = {};
  std::string at = {};
};

using Checked = tl::expected<void, FieldFault>;

tl::unexpected<FieldFault> fault(std::string message, std::string at = {}) {
  return tl::unexpected<FieldFault>({std::move(message), {}, std::move(at)});
}

tl::unexpected<FieldFault> outOfRange(const FieldRow& field, const FieldValue& value,
                                      const std::string& expected) {
  const auto larger = [](const FieldValue& one) {
    return one.is_number() && std::abs(one.get<double>()) > kLargest;
  };
  const bool large = !std::isfinite(field.most) &&
                     (value.is_array() ? std::ranges::any_of(value, larger) : larger(value));
  return fault(fmt::format("{} is out of range; expected {}{}", value.dump(), expected,
                           large ? fmt::format(", not beyond {:g}", kLargest) : ""));
}

Checked checkNumbers(const FieldRow& field, const FieldValue& value) {
  const auto [fewest, most] = countsOf(field);
  if (!value.is_array() || value.size() < fewest || value.size() > most)
    return fault("expected " + field.expected());
  for (std::size_t i = 0; i < value.size(); ++i) {
    if (!isNumber(value[i], field.whole))
      return fault(field.whole ? "expected a whole number" : "expected a number",
                   fmt::format("[{}]", i));
  }
  if (std::ranges::all_of(value,
                          [&](const FieldValue& v) { return holds(field, v.get<double>()); }))
    return {};
  return outOfRange(field, value, field.expected());
}

Checked checkRows(const FieldRow& field, const FieldValue& value) {
  if (!value.is_array())
    return fault("expected " + field.expected());
  FieldRow row = field;
  row.type = kNumbers;
  for (std::size_t i = 0; i < value.size(); ++i) {
    if (auto good = checkNumbers(row, value[i]); !good) {
      good.error().at = fmt::format("[{}]{}", i, good.error().at);
      return good;
    }
  }
  return {};
}

Checked checkChoice(const FieldRow& field, const FieldValue& value) {
  if (!value.is_string())
    return fault("expected " + field.expected());
  const auto& text = value.get_ref<const std::string&>();
  if (std::ranges::find(field.choices, text) != field.choices.end())
    return {};
  const auto near = nearest(text, field.choices);
  return fault(fmt::format("'{}' is unknown{}; expected {}", text,
                           near.empty() ? "" : fmt::format(" (did you mean '{}'?)", near),
                           field.expected()));
}

Checked checkFiles(const FieldRow& field, const FieldValue& value) {
  const bool list = field.several && value.is_array() && !value.empty();
  const auto isText = [](const FieldValue& one) { return one.is_string(); };
  if (isText(value) || (list && std::ranges::all_of(value, isText)))
    return {};
  return fault("expected " + field.expected());
}

Checked checkValue(const FieldRow& field, const FieldValue& value) {
  if (field.flagToo && value.is_boolean())
    return {};
  bool good = true;
  switch (field.type) {
    case kNumber:
      if (!field.choices.empty() && value.is_string())
        return {};  // the struct knows
      [[fallthrough]];
    case kInteger:
      good = isNumber(value, field.type == kInteger);
      if (good && !holds(field, value.get<double>()))
        return outOfRange(field, value, field.rangeText());
      break;
    case kFlag:
      good = value.is_boolean();
      break;
    case kText:
      good = value.is_string();
      break;
    case kChoice:
      return checkChoice(field, value);
    case kFile:
      return checkFiles(field, value);
    case kRows:
      return checkRows(field, value);
    case kObject:
      good = value.is_object();
      break;
    default:
      return checkNumbers(field, value);
  }
  return good ? Checked() : fault("expected " + field.expected());
}

/// Names of files as they are found, or as they are written in `file`.
template <class Change>
FieldValue withFiles(const FieldRow& field, FieldValue value, Change change) {
  if (field.type != kFile)
    return value;
  if (value.is_string())
    return change(value.get<std::string>());
  for (FieldValue& name : value) name = change(name.get<std::string>());
  return value;
}

Status checkNames(const FieldTable& table, const FieldValue& json, const FieldOrigin& origin) {
  if (!json.is_object()) {
    const bool vowel = std::string_view("aeiou").find(table.name.front()) != std::string_view::npos;
    return origin.wrong(fmt::format("expected {} {} object", vowel ? "an" : "a", table.name));
  }
  std::vector<std::string_view> names;
  if (!table.kind.empty())
    names.emplace_back("kind");
  for (const FieldRow& field : table.fields) names.push_back(field.name);
  for (const auto& [key, value] : json.items()) {
    if (table.find(key) || (key == "kind" && !table.kind.empty()))
      continue;
    const FieldRow unknown{.name = key};
    // Kinds of one name are told apart by the file's.
    for (const MediumKind* kind : mediumKinds()) {
      const FieldTable& other = kind->fields();
      if (!table.kind.empty() && other.kind == table.kind && other.find(key))
        return origin.wrong(unknown,
                            fmt::format("is for {}, and this is {}", other.things, table.thing));
    }
    const auto near = nearest(key, names);
    return origin.wrong(
        unknown,
        "this name is unknown" + (near.empty() ? "" : fmt::format("; did you mean '{}'?", near)));
  }
  return {};
}

/// Where it stands: by its name or its other name. Null where it is not said.
Result<const FieldValue*> saidIn(const FieldRow& field, const FieldValue& json,
                                 const FieldOrigin& origin) {
  const auto found = json.find(field.name);
  if (field.otherName.empty() || !json.contains(field.otherName))
    return found == json.end() ? nullptr : &*found;
  if (found != json.end())
    return origin.wrong(field, fmt::format("{} says the same; leave one out", field.otherName));
  return &json[std::string(field.otherName)];
}

Status readField(const FieldRow& field, const FieldValue& value, const FieldOrigin& origin,
                 void* object) {
  if (const auto good = checkValue(field, value); !good) {
    const FieldFault& wrong = good.error();
    return origin.wrong(field, wrong.message, wrong.at);
  }
  if (field.type == kObject && !value.is_boolean())
    return readFields(*field.table, value, origin.within(field), field.access.make(object));
  const auto found =
      withFiles(field, value, [&](const std::string& name) { return besides(origin.file, name); });
  const Status taken = field.access.set(field, object, found);
  if (taken)
    return {};
  Error error = origin.wrong(field, taken.error().message).value();
  if (taken.error().code == ErrorCode::kUnsupported)
    error.code = ErrorCode::kUnsupported;
  return tl::unexpected(std::move(error));
}

/// As a file's folder says it: from there where it is below, else absolute.
std::string nameBeside(const std::string& file, const std::string& name) {
  const auto near = std::filesystem::path(name).lexically_normal().lexically_relative(
      std::filesystem::path(file).parent_path().lexically_normal());
  return near.empty() || *near.begin() == ".." ? name : near.string();
}

}  // namespace

std::string FieldRow::optionName(std::string_view outer) const {
  std::string text = !option.name.empty() ? std::string(option.name)
                     : outer.empty()      ? std::string(name)
                                          : fmt::format("{}-{}", outer, name);
  std::ranges::replace(text, '_', '-');
  return text;
}

std::string FieldRow::rangeText() const {
  const bool low = std::isfinite(least), high = std::isfinite(most);
  if (low && high && !above && !below)
    return fmt::format("{:g} to {:g}", least, most);
  std::string text = low ? fmt::format("{} {:g}", above ? "more than" : "at least", least) : "";
  if (high)
    text += fmt::format("{}{} {:g}", low ? " and " : "", below ? "less than" : "at most", most);
  return text;
}

std::string FieldRow::expected() const {
  const std::string range = rangeText();
  const std::string unitText = unit.empty() ? "" : fmt::format(" [{}]", unit);
  const std::string_view of = range.empty() ? "" : " of ";
  switch (type) {
    case kNumber:
    case kInteger:
      return fmt::format(
          "a {}{}{}{}{}", type == kInteger ? "whole number" : "number", of, range, unitText,
          choices.empty() ? "" : fmt::format(", or one of {}", fmt::join(choices, ", ")));
    case kFlag:
      return "true or false";
    case kChoice:
      return fmt::format("one of {}", fmt::join(choices, ", "));
    case kText:
      return fmt::format("a text: {}", help);
    case kFile:
      return fmt::format("the name of a file: {}", help);
    case kRows:
      return fmt::format("a list of {} numbers each", numberWord(count));
    case kObject:
      return fmt::format("{}an object of {}", flagToo ? "true, false or " : "", table->name);
    case kPoint:
    case kDirection:
    case kColor:
    case kNumbers:
      break;
  }
  const std::string numbers = count == 0 ? "a list of"
                              : fewest > 0
                                  ? fmt::format("{} or {}", numberWord(fewest), numberWord(count))
                                  : numberWord(count);
  return fmt::format("{}{} {}numbers{}{}{}", flagToo ? "true, false or " : "", numbers,
                     whole ? "whole " : "", of, range, unitText);
}

std::string FieldRow::sentence() const {
  return unit.empty() ? std::string(help) : fmt::format("{} [{}]", help, unit);
}

const FieldRow* FieldTable::find(std::string_view wanted) const {
  const auto found = std::ranges::find_if(fields, [&](const FieldRow& field) {
    return field.name == wanted || (!wanted.empty() && field.otherName == wanted);
  });
  return found == fields.end() ? nullptr : &*found;
}

const FieldRow& FieldTable::at(std::string_view wanted) const {
  const FieldRow* found = find(wanted);
  VOLUTE_ASSERT(found);
  return *found;
}

std::string FieldOrigin::place(const FieldRow& field) const {
  return options() ? field.optionName(outer) : fmt::format("{}: {}/{}", file, path, field.name);
}

tl::unexpected<Error> FieldOrigin::wrong(const FieldRow& field, std::string_view message,
                                         std::string_view at) const {
  if (options())
    return failFor(fmt::format("{}{}", place(field), at), ErrorCode::kInvalidArgument, "{}",
                   message);
  return failIn(file, fmt::format("{}/{}{}", path, field.name, at), ErrorCode::kInvalidData, "{}",
                message);
}

tl::unexpected<Error> FieldOrigin::wrong(std::string_view message) const {
  if (options())
    return failFor(outer, ErrorCode::kInvalidArgument, "{}", message);
  return failIn(file, path, ErrorCode::kInvalidData, "{}", message);
}

FieldOrigin FieldOrigin::within(const FieldRow& field) const {
  return {file, fmt::format("{}/{}", path, field.name), options() ? field.optionName(outer) : ""};
}

Status readFields(const FieldTable& table, const FieldValue& json, const FieldOrigin& origin,
                  void* object) {
  VOLUTE_TRY(checkNames(table, json, origin));
  for (const FieldRow& field : table.fields) {
    VOLUTE_ASSIGN(const FieldValue* said, saidIn(field, json, origin));
    if (!said && field.required)
      return origin.wrong(field, "is missing; expected " + field.expected());
    if (said)
      VOLUTE_TRY(readField(field, *said, origin, object));
  }
  return {};
}

std::vector<std::string> filesIn(const FieldTable& table) {
  std::vector<std::string> names;
  for (const FieldRow& field : table.fields) {
    if (field.type == kFile)
      names.emplace_back(field.name);
    for (const std::string& inner : field.table ? filesIn(*field.table) : decltype(names)())
      names.push_back(fmt::format("{}/{}", field.name, inner));
  }
  return names;
}

FieldValue usualValue(const FieldTable& table, const FieldRow& field) {
  if (field.required || field.inherited || !field.access.get)
    return {};
  return field.access.get(field, table.usual);
}

nlohmann::ordered_json writeFields(const FieldTable& table, const void* object,
                                   const std::string& file) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  if (!table.kind.empty())
    json["kind"] = table.kind;
  for (const FieldRow& field : table.fields) {
    const std::string key(field.name);
    if (field.access.find && !(field.access.get && !field.access.get(field, object).is_null())) {
      const void* inner = field.access.find(object);
      auto members = inner ? writeFields(*field.table, inner, file) : nlohmann::ordered_json();
      if (!members.empty())
        json[key] = std::move(members);
      continue;
    }
    FieldValue value = field.access.get(field, object);
    if (field.several && value.size() == 1)
      value = FieldValue(value[0]);
    if (value.is_null() || (!field.required && value == usualValue(table, field)))
      continue;
    json[key] =
        withFiles(field, value, [&](const std::string& name) { return nameBeside(file, name); });
  }
  return json;
}

Status eachEntry(
    const FieldValue& json, const FieldOrigin& origin,
    const std::function<Status(const FieldValue& entry, const FieldOrigin& origin)>& read) {
  if (!json.is_array())
    return origin.wrong("expected a list");
  for (std::size_t i = 0; i < json.size(); ++i)
    VOLUTE_TRY(read(json[i], {origin.file, fmt::format("{}/{}", origin.path, i)}));
  return {};
}

}  // namespace volute
