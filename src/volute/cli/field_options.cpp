// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/field_options.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "volute/cli/file_kind.hpp"

namespace volute::cli {
namespace {

/// Members of such an object have options of their own.
bool hasInnerOptions(const FieldRow& field) {
  return field.table && !field.option.parse;
}

ValueKind valueKind(const FieldRow& field) {
  if (!field.option.flagValue.empty())
    return ValueKind::kFlag;
  if (field.option.parse)
    return ValueKind::kText;
  switch (field.type) {
    case FieldType::kNumber:
      return field.choices.empty() ? ValueKind::kNumber : ValueKind::kText;
    case FieldType::kInteger:
      return ValueKind::kInteger;
    case FieldType::kFlag:
      return ValueKind::kFlag;
    case FieldType::kChoice:
      return ValueKind::kChoice;
    case FieldType::kFile:
      return ValueKind::kFile;
    case FieldType::kPoint:
    case FieldType::kDirection:
    case FieldType::kColor:
      return ValueKind::kVector;
    case FieldType::kRows:
      return ValueKind::kBounds;  // two corners; other rows have no option
    default:
      return ValueKind::kText;
  }
}

/// As a user would type it.
std::string typed(const FieldValue& value) {
  if (value.is_number())
    return fmt::format("{:g}", value.get<double>());
  if (value.is_string())
    return value.get<std::string>();
  return value.is_array() && value.size() == 3
             ? fmt::format("{:g}", fmt::join(value.get<std::vector<double>>(), ","))
             : "";
}

Option optionOf(const FieldTable& table, const FieldRow& field, std::string_view outer) {
  Option option{.name = field.optionName(outer),
                .kind = valueKind(field),
                .value = field.option.value,
                .help = field.sentence() + std::string(field.option.more),
                .initial = std::string(field.option.initial)};
  if (option.kind == ValueKind::kText && !field.choices.empty())
    option.help += fmt::format("; a number or {}", fmt::join(field.choices, ", "));
  if (option.kind == ValueKind::kChoice)
    option.choices = {field.choices.begin(), field.choices.end()};
  if (option.kind == ValueKind::kNumber || option.kind == ValueKind::kInteger) {
    option.least = field.least, option.most = field.most;
    option.positive = field.above && field.least == 0, option.below = field.below;
  }
  if (option.initial.empty() && option.kind != ValueKind::kFlag && !field.option.parse)
    option.initial = typed(usualValue(table, field));
  if (!field.otherName.empty())
    option.aliases = {field.otherName};
  option.beside = field.option.beside;
  return option;
}

void addKind(Option& option, std::string_view kind) {
  if (std::ranges::find(option.kinds, kind) == option.kinds.end())
    option.kinds.push_back(kind);
}

/// Into one that another kind has as well.
void join(Option& into, const Option& more) {
  if (into.help.find(more.help) == std::string::npos)
    into.help += "; " + more.help;
  into.aliases.insert(into.aliases.end(), more.aliases.begin(), more.aliases.end());
  if (into.initial != more.initial)
    into.initial.clear();
}

void addOptions(std::vector<Option>& options, const FieldTable& table, std::string_view kind,
                FieldUse use, std::string_view outer) {
  for (const FieldRow& field : table.fields) {
    if (hasInnerOptions(field))
      addOptions(options, *field.table, kind, use, field.name);
    if (!field.hasOption() || (use == FieldUse::kMeasured && field.option.picture))
      continue;
    Option made = optionOf(table, field, outer);
    auto there = std::ranges::find(options, made.name, &Option::name);
    if (there == options.end())
      there = options.insert(options.end(), std::move(made));
    else
      join(*there, made);
    addKind(*there, kind);
    if (field.option.scene)
      addKind(*there, kSceneKind);
  }
}

/// "FDS cases: ", where others of the tables do not have it.
std::string forWhom(const Option& option, const std::vector<const FieldTable*>& tables) {
  std::vector<std::string_view> things;
  bool all = true;
  for (const FieldTable* table : tables) {
    const bool has = std::ranges::find(option.kinds, table->name) != option.kinds.end();
    if (has && !table->things.empty())
      things.push_back(table->things);
    all = all && (has || table->things.empty());
  }
  return all || things.empty() ? "" : fmt::format("{}: ", fmt::join(things, " and "));
}

Result<FieldValue> textValue(const FieldRow& field, const std::string& text) {
  if (field.option.parse)
    return field.option.parse(text);
  if (field.type == FieldType::kNumbers) {
    VOLUTE_ASSIGN(auto numbers, parseNumbers(text));
    return FieldValue(std::move(numbers));
  }
  const auto number = parseNumber(text);
  return field.type == FieldType::kNumber && number ? FieldValue(*number) : FieldValue(text);
}

FieldValue numbersOf(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

Result<FieldValue> saidBy(const FieldRow& field, const std::string& name,
                          const Arguments& arguments) {
  switch (valueKind(field)) {
    case ValueKind::kFlag:
      return field.option.flagValue.empty() ? FieldValue(true) : FieldValue(field.option.flagValue);
    case ValueKind::kNumber:
      return *arguments.find<double>(name);
    case ValueKind::kInteger:
      return *arguments.find<int>(name);
    case ValueKind::kVector:
      return numbersOf(*arguments.find<Vec3>(name));
    case ValueKind::kBounds: {
      const Box3 box = *arguments.find<Box3>(name);
      return FieldValue{numbersOf(box.min), numbersOf(box.max)};
    }
    case ValueKind::kText:
      return textValue(field, *arguments.find<std::string>(name));
    default:
      return *arguments.find<std::string>(name);
  }
}

Status addMembers(FieldValue& members, const FieldTable& table, const Arguments& arguments,
                  std::string_view outer) {
  for (const FieldRow& field : table.fields) {
    const std::string key(field.name), name = field.optionName(outer);
    if (hasInnerOptions(field)) {
      FieldValue inner = FieldValue::object();
      VOLUTE_TRY(addMembers(inner, *field.table, arguments, field.name));
      if (!inner.empty())
        members[key] = std::move(inner);
    }
    // A default that is not the struct's is said as well.
    const bool said = arguments.given(name) ||
                      (!field.option.initial.empty() && arguments.value(name) != nullptr);
    if (!field.hasOption() || !said)
      continue;
    auto value = saidBy(field, name, arguments);
    if (!value)
      return fail(ErrorCode::kInvalidArgument, "--{}: {}", name, value.error().message);
    members[key] = std::move(*value);
  }
  return {};
}

}  // namespace

std::vector<Option> fieldOptions(const std::vector<const FieldTable*>& tables, FieldUse use) {
  std::vector<Option> options;
  for (const FieldTable* table : tables) addOptions(options, *table, table->name, use, "");
  for (Option& option : options) {
    option.help = forWhom(option, tables) + option.help;
    std::ranges::stable_partition(option.kinds, [](auto kind) { return kind != kSceneKind; });
  }
  return options;
}

Result<FieldValue> membersOf(const FieldTable& table, const Arguments& arguments) {
  FieldValue members = FieldValue::object();
  VOLUTE_TRY(addMembers(members, table, arguments, ""));
  return members;
}

std::string optionOfMember(const FieldTable& table, std::string_view member) {
  const std::size_t slash = std::min(member.find('/'), member.size());
  const FieldRow* row = table.find(member.substr(0, slash));
  std::string_view outer;
  if (row && slash < member.size() && hasInnerOptions(*row)) {
    outer = row->name;
    row = row->table->find(member.substr(slash + 1));
  }
  return row && row->hasOption() ? row->optionName(outer) : "";
}

}  // namespace volute::cli
