// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "volute/base/lower_case.hpp"
#include "volute/base/number_word.hpp"
#include "volute/base/result.hpp"

// Tables of text: one row a line, as spreadsheets write them.

namespace volute {

/// Without blanks, tabs and carriage returns at both ends.
inline std::string_view trimmedField(std::string_view text) {
  const auto isSpace = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (!text.empty() && isSpace(text.front())) text.remove_prefix(1);
  while (!text.empty() && isSpace(text.back())) text.remove_suffix(1);
  return text;
}

/// The number that all of `text` is; nothing for other text, infinities and NaN.
inline std::optional<double> finiteNumber(std::string_view text) {
  double value = 0;
  if (!readNumber(text, value) || !std::isfinite(value))
    return std::nullopt;
  return value;
}

/// What separates the fields of a table with this first line: semicolons, tabs or commas outside
/// quotes.
inline char separatorOf(std::string_view line) {
  char found = '\0';
  bool quoted = false;
  for (const char c : line) {
    quoted = quoted != (c == '"');
    if (!quoted && (c == ';' || (c == '\t' && found != ';') || (c == ',' && found == '\0')))
      found = c;
  }
  return found == '\0' ? ',' : found;
}

/// Fields between separators, '\0' for blanks and tabs; quotes around a field are dropped.
inline std::vector<std::string_view> fieldsOf(std::string_view line, char separator) {
  std::vector<std::string_view> fields;
  if (separator == '\0') {
    constexpr std::string_view kBlanks = " \t\r";
    for (std::size_t begin = line.find_first_not_of(kBlanks); begin != line.npos;) {
      const std::size_t end = std::min(line.find_first_of(kBlanks, begin), line.size());
      fields.push_back(line.substr(begin, end - begin));
      begin = line.find_first_not_of(kBlanks, end);
    }
    return fields;
  }
  for (std::size_t begin = 0;;) {
    bool quoted = false;
    std::size_t end = begin;
    for (; end < line.size() && (quoted || line[end] != separator); ++end)
      quoted = quoted != (line[end] == '"');
    auto field = trimmedField(line.substr(begin, end - begin));
    if (field.size() >= 2 && field.front() == '"' && field.back() == '"')
      field = trimmedField(field.substr(1, field.size() - 2));
    fields.push_back(field);
    if (end == line.size())
      return fields;
    begin = end + 1;
  }
}

/// The number that a Fortran program wrote: also 1.0D-3, and 2.0-101, where there was no place for
/// the E.
inline std::optional<double> fortranNumber(std::string_view text) {
  if (const auto value = finiteNumber(text))
    return value;
  std::string number(text);
  const std::size_t letter = number.find_first_of("dD");
  const std::size_t sign = number.find_first_of("+-", 1);
  if (letter != number.npos)
    number[letter] = 'e';
  else if (sign != number.npos && number.find_first_of("eE") == number.npos)
    number.insert(sign, 1, 'e');
  const std::size_t plus = number.find("e+");
  return finiteNumber(plus == number.npos ? number : number.erase(plus + 1, 1));
}

/// With a decimal comma, where commas do not separate: 1,5;2,5 is what spreadsheets of many
/// countries write. Other text as it is.
inline std::string withPoint(std::string_view field, char separator) {
  std::string text(field);
  const std::size_t comma = text.find(',');
  if ((separator == ';' || separator == '\t') && comma != text.npos &&
      text.find_first_of(",.", comma + 1) == text.npos && text.find('.') == text.npos)
    text[comma] = '.';
  return text;
}

/// Calls visit(line, number) until it fails; lines are trimmed and numbered from 1.
template <class Visit>
Status forEachRow(std::string_view text, Visit&& visit) {
  if (text.starts_with("\xEF\xBB\xBF"))
    text.remove_prefix(3);
  int number = 0;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    VOLUTE_TRY(visit(trimmedField(text.substr(0, end)), ++number));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return {};
}

}  // namespace volute
