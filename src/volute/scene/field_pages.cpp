// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/field_pages.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace volute {
namespace {

using OrderedJson = nlohmann::ordered_json;
using enum FieldType;

OrderedJson numberSchema(const FieldRow& field, bool whole) {
  OrderedJson json = {{"type", whole ? "integer" : "number"}};
  if (std::isfinite(field.least))
    json[field.above ? "exclusiveMinimum" : "minimum"] = field.least;
  if (std::isfinite(field.most))
    json[field.below ? "exclusiveMaximum" : "maximum"] = field.most;
  return json;
}

OrderedJson numbersSchema(const FieldRow& field) {
  OrderedJson json = {{"type", "array"}, {"items", numberSchema(field, field.whole)}};
  if (field.count > 0) {
    json["minItems"] = field.fewest > 0 ? field.fewest : field.count;
    json["maxItems"] = field.count;
  }
  return json;
}

/// Without what only this member has.
OrderedJson valueSchema(const FieldRow& field) {
  switch (field.type) {
    case kNumber:
      if (!field.choices.empty())
        return {{"oneOf", {numberSchema(field, false), {{"type", "string"}}}}};
      return numberSchema(field, false);
    case kInteger:
      return numberSchema(field, true);
    case kFlag:
      return {{"type", "boolean"}};
    case kChoice:
      return {{"enum", std::vector<std::string>(field.choices.begin(), field.choices.end())}};
    case kFile:
    case kText: {
      OrderedJson one = {{"type", "string"}};
      if (!field.pattern.empty())
        one["pattern"] = field.pattern;
      if (!field.several)
        return one;
      return {{"oneOf", {one, {{"type", "array"}, {"items", one}, {"minItems", 1}}}}};
    }
    case kRows:
      return {{"type", "array"}, {"items", numbersSchema(field)}};
    case kObject:
      return {{"$ref", fmt::format("#/$defs/{}", field.table->name)}};
    default:
      return numbersSchema(field);
  }
}

OrderedJson memberSchema(const FieldTable& table, const FieldRow& field) {
  OrderedJson json = {{"description", field.sentence()}};
  if (field.flagToo)
    json["oneOf"] = {{{"type", "boolean"}}, valueSchema(field)};
  else
    json.update(valueSchema(field));
  if (const FieldValue usual = usualValue(table, field); !usual.is_null() && usual != "")
    json["default"] = OrderedJson::parse(usual.dump());
  return json;
}

std::string cellText(std::string_view text) {
  std::string out;
  for (const char c : text) out += c == '|' ? std::string("\\|") : std::string(1, c);
  return out;
}

std::string usualText(const FieldTable& table, const FieldRow& field) {
  if (field.required)
    return "required";
  const FieldValue usual = usualValue(table, field);
  return usual.is_null() || usual == "" || usual == FieldValue::array()
             ? ""
             : fmt::format("`{}`", usual.dump());
}

std::string optionText(const FieldRow& field, std::string_view outer) {
  return field.hasOption() ? fmt::format("`--{}`", field.optionName(outer)) : "";
}

std::string valueText(const FieldRow& field) {
  switch (field.type) {
    case kText:
      return "a text";
    case kFile:
      return field.several ? "a file's name, or a list of them" : "a file's name";
    case kChoice:
      return fmt::format("`{}`", fmt::join(field.choices, "`, `"));
    case kObject:
      return fmt::format("{}[{}](#{})", field.flagToo ? "true, false or " : "", field.table->name,
                         field.table->name);
    default:
      return field.expected();
  }
}

}  // namespace

void addSchema(const FieldTable& table, OrderedJson& defs) {
  if (defs.contains(table.name))
    return;
  OrderedJson properties = OrderedJson::object();
  OrderedJson required = OrderedJson::array();
  if (!table.kind.empty()) {
    properties["kind"] = {{"const", table.kind}};
    required.emplace_back("kind");
  }
  for (const FieldRow& field : table.fields) {
    properties[std::string(field.name)] = memberSchema(table, field);
    if (!field.otherName.empty())
      properties[std::string(field.otherName)] = {
          {"description", fmt::format("another name of {}", field.name)}, {"type", "string"}};
    if (field.required)
      required.emplace_back(field.name);
  }
  defs[std::string(table.name)] = {{"description", table.sentence},
                                   {"type", "object"},
                                   {"required", std::move(required)},
                                   {"additionalProperties", false},
                                   {"properties", std::move(properties)}};
  for (const FieldRow& field : table.fields) {
    if (field.table)
      addSchema(*field.table, defs);
  }
}

std::string membersTable(const FieldTable& table, std::set<const FieldTable*>& done,
                         std::string_view outer) {
  if (!done.insert(&table).second)
    return "";
  std::string page = fmt::format(
      "\n## {}\n\n{}{}.\n\n| member | value | default | meaning | option "
      "|\n|---|---|---|---|---|\n",
      table.name, table.sentence,
      table.kind.empty() ? "" : fmt::format("; `kind` is `{}`", table.kind));
  for (const FieldRow& field : table.fields) {
    page += fmt::format("| `{}` | {} | {} | {} | {} |\n", field.name, cellText(valueText(field)),
                        usualText(table, field), cellText(field.help), optionText(field, outer));
  }
  for (const FieldRow& field : table.fields) {
    if (field.table)
      page += membersTable(*field.table, done, field.name);
  }
  return page;
}

}  // namespace volute
