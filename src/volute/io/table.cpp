// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/table.hpp"

#include <fmt/ranges.h>

#include <algorithm>

#include "volute/base/printable.hpp"
#include "volute/base/suggest.hpp"

namespace volute {
namespace {

constexpr std::size_t kShown = 60;  // letters of a cell in a message

struct NameAndUnit {
  std::string name;  ///< in lower case
  std::optional<std::string> unit;
};

/// "x [cm]", "x[in cm]", "x (cm)", "x/cm", "x in cm".
NameAndUnit splitName(std::string_view field) {
  while (field.starts_with('#')) field = trimmedField(field.substr(1));
  std::size_t end = field.npos, unit = field.npos, close = field.size();
  if (field.ends_with(']') || field.ends_with(')')) {
    end = field.rfind(field.back() == ']' ? '[' : '(');
    unit = end + 1;
    close = field.size() - 1;
  } else if (field.find('/') != field.npos) {
    end = field.find('/');
    unit = end + 1;
  } else if (const std::size_t in = field.find(" in "); in != field.npos) {
    end = in;
    unit = in + 4;
  }
  NameAndUnit split{lowerCase(trimmedField(field.substr(0, end))), std::nullopt};
  if (end != field.npos) {
    std::string_view text = trimmedField(field.substr(unit, close - unit));
    if (text.starts_with("in ") && text.size() > 3)
      text = trimmedField(text.substr(3));
    split.unit = std::string(text);
  }
  std::ranges::replace(split.name, '_', ' ');
  return split;
}

bool isNumber(std::string_view field, char separator) {
  double value = 0;
  return readNumber(withPoint(field, separator), value);  // infinities and NaN too
}

}  // namespace

TableReader::TableReader(std::string_view file, std::vector<TableColumn> columns, TableRules rules)
    : file_(file),
      columns_(std::move(columns)),
      rules_(std::move(rules)),
      places_(columns_.size(), -1),
      changes_(columns_.size()),
      stated_(columns_.size(), false) {}

std::string TableReader::names() const {
  std::vector<std::string_view> names;
  for (const TableColumn& column : columns_) names.push_back(column.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

Status TableReader::useUnit(std::size_t column, std::string_view unit) {
  const TableColumn& one = columns_[column];
  const auto change = one.text || (one.unit.empty() && !unit.empty())
                          ? std::nullopt
                          : unitChange(unit.empty() ? one.unit : unit, one.unit);
  if (!change && !(one.text && unit.empty())) {
    return fail(ErrorCode::kInvalidData, "{}: {} is in '{}'; expected {}", where(), one.name,
                unit.substr(0, kShown),
                one.unit.empty() ? "a column without a unit"
                                 : fmt::format("{} or another unit of the same kind", one.unit));
  }
  if (stated_[column] && !unit.empty() &&
      // NOLINTNEXTLINE(bugprone-unchecked-optional-access): units only where there is one
      (change->factor != changes_[column].factor || change->offset != changes_[column].offset)) {
    return fail(ErrorCode::kInvalidData,
                "{}: {} is in '{}', and its name has another unit: correct one of them", where(),
                one.name, unit.substr(0, kShown));
  }
  if (change && !unit.empty()) {
    changes_[column] = *change;
    stated_[column] = true;
  }
  return {};
}

Status TableReader::takeNames(std::string_view line) {
  separator_ = rules_.blanks ? '\0' : separatorOf(line);
  const auto fields = fieldsOf(line, separator_);
  std::vector<std::string> unknown, spare;
  std::vector<std::string_view> known;
  for (const TableColumn& column : columns_) {
    known.push_back(column.name);
    known.insert(known.end(), column.others.begin(), column.others.end());
  }
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const NameAndUnit split = splitName(fields[i]);
    const auto found = std::ranges::find_if(columns_, [&](const TableColumn& column) {
      const auto is = [&](std::string_view name) {
        std::string spaced(name);
        std::ranges::replace(spaced, '_', ' ');
        return spaced == split.name;
      };
      return is(column.name) || std::ranges::any_of(column.others, is);
    });
    if (found == columns_.end()) {
      const bool leftOut = fields[i].empty() || (fields[i].starts_with('#') && i > 0);
      const bool isSpare = std::ranges::find(rules_.spare, split.name) != rules_.spare.end();
      if (!leftOut)
        (isSpare ? spare : unknown).emplace_back(fields[i].substr(0, kShown));
      continue;
    }
    const auto column = static_cast<std::size_t>(found - columns_.begin());
    if (places_[column] >= 0) {
      return fail(ErrorCode::kInvalidData, "{}: two columns are called '{}'", where(), found->name);
    }
    places_[column] = static_cast<int>(i);
    VOLUTE_TRY(useUnit(column, split.unit.value_or("")));
  }
  count_ = fields.size();
  const auto leaveOut = [&](RemarkCode code, const std::vector<std::string>& names) {
    if (!names.empty())
      remarks_.emplace_back(
          code, fmt::format("{}: not used of its columns: {}", file_, fmt::join(names, ", ")));
  };
  leaveOut(RemarkCode::kNote, spare);
  if (unknown.empty())
    return {};
  if (!rules_.own) {
    leaveOut(RemarkCode::kLeftOut, unknown);
    return {};
  }
  std::string name = splitName(unknown.front()).name;
  std::ranges::replace(name, ' ', '_');
  const std::string_view meant = nearest(name, known);
  return fail(ErrorCode::kInvalidData,
              "{}: unknown column '{}'{}; expected {}: take it out, or begin its name with # to "
              "leave it out",
              where(), unknown.front(),
              meant.empty() ? "" : fmt::format(": did you mean '{}'?", meant), names());
}

/// Whether the line below the names says units.
bool TableReader::holdsUnits() const {
  bool any = false;
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    if (!has(i) || columns_[i].text)
      continue;
    const std::string_view field = text(i);
    if (isNumber(field, separator_) || !isUnit(field))
      return false;
    any = any || !field.empty();
  }
  return any;
}

Status TableReader::readUnits() {
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    if (has(i) && !columns_[i].text)
      VOLUTE_TRY(useUnit(i, text(i)));
  }
  return {};
}

Result<bool> TableReader::take(std::string_view line) {
  ++line_;
  lineText_ = asUtf8(trimmedField(line));
  line = lineText_;
  if (line.empty() || (line.starts_with('#') && count_ > 0))
    return false;
  if (count_ == 0) {
    if (line.starts_with('#'))
      return false;
    separator_ = rules_.blanks ? '\0' : separatorOf(line);
    fields_ = fieldsOf(line, separator_);
    if (std::ranges::none_of(fields_,
                             [&](std::string_view field) { return isNumber(field, separator_); })) {
      VOLUTE_TRY(takeNames(line));
      return false;
    }
    if (rules_.unnamed[1] == 0) {
      return fail(ErrorCode::kInvalidData, "{}: expected a line with the names of columns: {}",
                  where(), names());
    }
    count_ = fields_.size();
    firstRow_ = false;
    if (count_ > rules_.unnamed[1] && !rules_.longer) {
      return fail(ErrorCode::kInvalidData,
                  "{}: {} columns without names; expected a line above that names them: {}",
                  where(), count_, names());
    }
    for (std::size_t i = 0; i < std::min(count_, rules_.unnamed[1]); ++i)
      places_[i] = static_cast<int>(i);
    if (count_ < rules_.unnamed[0]) {
      return fail(ErrorCode::kInvalidData, "{}: {} is missing; expected {} in each line", where(),
                  columns_[count_].name, names());
    }
  } else {
    fields_ = fieldsOf(line, separator_);
    // Spreadsheets end lines in empty fields.
    while (fields_.size() > count_ && fields_.back().empty()) fields_.pop_back();
    if (rules_.longer && firstRow_)
      count_ = std::max(static_cast<std::size_t>(std::ranges::max(places_) + 1), fields_.size());
  }
  if (fields_.size() != count_) {
    return fail(ErrorCode::kInvalidData,
                "{}: {} columns; expected {} as in the first line: is a value missing, a separator "
                "too many, or the file cut off?",
                where(), fields_.size(), count_);
  }
  if (firstRow_ && holdsUnits()) {
    firstRow_ = false;
    VOLUTE_TRY(readUnits());
    return false;
  }
  firstRow_ = false;
  return true;
}

Result<double> TableReader::number(std::size_t column) const {
  const std::string_view field = text(column);
  const std::string point = withPoint(field, separator_);
  const auto value = rules_.own ? finiteNumber(point) : fortranNumber(point);
  if (value)
    return changes_[column](*value);
  const TableColumn& one = columns_[column];
  return fail(ErrorCode::kInvalidData, "{}: {} is '{}'; expected a number{}{}", where(), one.name,
              field.substr(0, kShown), one.unit.empty() ? "" : " in ", one.unit);
}

Result<double> TableReader::whole(std::size_t column, double least, double most) const {
  const auto value = number(column);
  if (value && *value == std::floor(*value) && *value >= least && *value <= most)
    return *value;
  return fail(ErrorCode::kInvalidData, "{}: {} is '{}'; expected a whole number from {:.0f} on",
              where(), columns_[column].name, text(column).substr(0, kShown), least);
}

}  // namespace volute
