// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/io/number_word.hpp"

// Tables of text: one row a line, as spreadsheets write them.

namespace volute {

/// Without blanks, tabs and carriage returns at both ends.
inline std::string_view trimmedField(std::string_view text) {
  const auto isSpace = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (!text.empty() && isSpace(text.front())) text.remove_prefix(1);
  while (!text.empty() && isSpace(text.back())) text.remove_suffix(1);
  return text;
}

/// In lower case, letters of ASCII alone.
inline std::string lowerCase(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return lower;
}

/// The number that all of `text` is; nothing for other text, infinities and NaN.
inline std::optional<double> finiteNumber(std::string_view text) {
  double value = 0;
  if (!readNumber(text, value) || !std::isfinite(value))
    return std::nullopt;
  return value;
}

/// Fields between commas, or semicolons where a line has them; quotes around a field are
/// dropped.
inline std::vector<std::string_view> fieldsOf(std::string_view line) {
  const char separator = line.find(';') != line.npos ? ';' : ',';
  std::vector<std::string_view> fields;
  for (std::size_t begin = 0;;) {
    bool quoted = false;
    std::size_t end = begin;
    for (; end < line.size() && (quoted || line[end] != separator); ++end)
      quoted = quoted != (line[end] == '"');
    end = end < line.size() ? end : line.npos;
    auto field = trimmedField(line.substr(begin, end == line.npos ? line.npos : end - begin));
    if (field.size() >= 2 && field.front() == '"' && field.back() == '"')
      field = field.substr(1, field.size() - 2);
    fields.push_back(field);
    if (end == line.npos)
      break;
    begin = end + 1;
  }
  return fields;
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
