// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "volute/base/remark.hpp"
#include "volute/base/result.hpp"
#include "volute/io/table_row.hpp"
#include "volute/io/unit.hpp"

// Tables of text whose columns have names and units.

namespace volute {

/// A column that a table may have.
struct TableColumn {
  std::string_view name;                      ///< in lower case
  std::string_view unit = "";                 ///< that number() is in; empty: a plain number
  std::vector<std::string_view> others = {};  ///< names that mean the same, in lower case
  bool text = false;                          ///< any words
};

/// What is known of a table before it is read.
struct TableRules {
  /// Columns that nobody knows are refused; else a table of another program has them, and remarks()
  /// names them.
  bool own = true;
  /// Where no line names columns, from so many to so many numbers a line mean the first ones. 0:
  /// there must be names.
  std::array<std::size_t, 2> unnamed{0, 0};
  bool blanks = false;  ///< blanks separate fields
  bool longer = false;  ///< lines may have more fields than there are names
  /// Columns that other programs always write and nobody needs here: leaving them out is a note.
  std::vector<std::string_view> spare = {};
};

/// Reads a table line by line: names of columns, units in their names ("x [cm]", "time/min", "z
/// (mm)") or in a line below, then values. Empty lines and those that begin with # do not count.
/// Errors name the file, the line, and the column.
class TableReader {
 public:
  TableReader(std::string_view file, std::vector<TableColumn> columns, TableRules rules);

  /// Takes the next line of the file; whether it has values.
  [[nodiscard]] Result<bool> take(std::string_view line);

  /// Takes a line that names columns, wherever it stands.
  [[nodiscard]] Status takeNames(std::string_view line);

  /// Counts a line that the caller reads itself.
  void skip() { ++line_; }

  bool named() const { return count_ > 0; }

  bool has(std::size_t column) const { return places_[column] >= 0; }

  /// The value in a column that the table has, in the column's unit.
  [[nodiscard]] Result<double> number(std::size_t column) const;

  /// The same, between `least` and `most` and whole.
  [[nodiscard]] Result<double> whole(std::size_t column, double least, double most) const;

  std::string_view text(std::size_t column) const {
    return fields_[static_cast<std::size_t>(places_[column])];
  }

  /// What makes a field of a column its number().
  const UnitChange& change(std::size_t column) const { return changes_[column]; }

  std::string where() const { return file_ + ": line " + std::to_string(line_); }

  int line() const { return line_; }  ///< from 1

  std::span<const Remark> remarks() const { return remarks_; }

 private:
  Status readUnits();
  Status useUnit(std::size_t column, std::string_view unit);
  std::string names() const;
  bool holdsUnits() const;

  std::string file_;
  std::vector<TableColumn> columns_;
  TableRules rules_;
  std::vector<int> places_;          // of each column; -1: it is not there
  std::vector<UnitChange> changes_;  // of each column
  std::vector<bool> stated_;         // of each column: its name has a unit
  std::size_t count_ = 0;            // of fields in a line; 0: not known yet
  bool firstRow_ = true;
  char separator_ = '\0';
  int line_ = 0;
  std::string lineText_;  // where it had to be decoded
  std::vector<std::string_view> fields_;
  std::vector<Remark> remarks_;
};

/// Takes all lines of `text`; calls visit() for each line of values.
template <class Visit>
Status readTable(TableReader& table, std::string_view text, Visit&& visit) {
  return forEachRow(text, [&](std::string_view line, int) -> Status {
    VOLUTE_ASSIGN(const bool values, table.take(line));
    return values ? visit() : Status{};
  });
}

}  // namespace volute
