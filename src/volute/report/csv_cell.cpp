// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/report/csv_cell.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "volute/base/printable.hpp"

namespace volute {
namespace {

bool isNumber(std::string_view text) {
  double value = 0;
  const char* const end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && rest == end && std::isfinite(value);
}

}  // namespace

std::string csvCell(std::string_view text) {
  const bool formula = !text.empty() &&
                       std::string_view("=+-@\t\r\n").find(text.front()) != text.npos &&
                       !isNumber(text);
  std::string cell;
  bool quotes = false;
  if (formula)
    cell += '\'';
  std::string line(text);
  std::ranges::replace_if(line, [](char c) { return c == '\n' || c == '\r'; }, ' ');
  for (const char c : printable(line)) {
    quotes = quotes || c == ',' || c == '"';
    if (c == '"')
      cell += '"';
    cell += c;
  }
  return quotes ? '"' + cell + '"' : cell;
}

}  // namespace volute
