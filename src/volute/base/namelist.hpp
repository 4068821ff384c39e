// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace volute {

/// Names of Fortran are the same in either case: this one's in capitals.
std::string capitals(std::string_view text);

/// "&GROUP KEY=value, ... /" of Fortran.
struct Namelist {
  std::string group;  ///< in capitals
  int line = 0;       ///< from 1, where it begins
  /// By key in capitals, without indices: strings without quotes, repetitions written out.
  std::map<std::string, std::vector<std::string>> values;

  /// The first value of a key; empty without one.
  std::string text(const std::string& key) const;
  std::optional<double> number(const std::string& key) const;
};

/// All groups with one of these names, in order. What is between groups, after a slash, or after an
/// exclamation mark is comment; a group that the file's end or the next one cuts off has what
/// stands there.
std::vector<Namelist> namelists(std::string_view text, const std::vector<std::string_view>& groups);

}  // namespace volute
