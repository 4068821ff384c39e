// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "volute/base/result.hpp"

namespace volute {

/// The tables of an SQLite 3 database, read by the layout that sqlite.org/fileformat2.html gives:
/// no query is run and nothing of the file is executed. Tables WITHOUT ROWID, virtual tables and
/// text in UTF-16 are refused.
class SqliteFile {
 public:
  /// NULL, a whole number, a number, or text and blobs as bytes.
  using Value = std::variant<std::monostate, std::int64_t, double, std::string>;
  using Visit = std::function<Status(std::span<const Value> row)>;

  static bool isOne(std::string_view bytes);

  /// The bytes of a file, which must outlive this. `name` is for messages.
  [[nodiscard]] static Result<SqliteFile> open(std::string_view bytes, std::string_view name);

  struct Table {
    std::string name;
    std::vector<std::string> columns;
    std::uint32_t root = 0;  ///< page
    int rowId = -1;          ///< the column that stands for it
  };

  std::span<const Table> tables() const { return tables_; }

  /// kNotFound where the database has no such table, or the table none of such a column.
  [[nodiscard]] Status forEachRow(std::string_view table, std::span<const std::string_view> columns,
                                  const Visit& visit) const;

 private:
  SqliteFile(std::string_view bytes, std::string_view name) : bytes_(bytes), name_(name) {}

  Status readSchema();
  tl::unexpected<Error> damaged(std::uint32_t page) const;
  Result<std::string_view> page(std::uint32_t number) const;
  Status walk(std::uint32_t number, int depth, std::size_t& budget, const Table& table,
              const Visit& visit) const;
  Result<std::string> payload(std::string_view page, std::uint32_t number, std::size_t at,
                              std::uint64_t size) const;
  Result<std::vector<Value>> record(std::string_view payload, std::uint32_t number) const;

  std::string_view bytes_;
  std::string name_;
  std::size_t pageSize_ = 0;
  std::size_t usable_ = 0;  // of a page
  std::uint32_t pages_ = 0;
  std::vector<Table> tables_;
};

}  // namespace volute
