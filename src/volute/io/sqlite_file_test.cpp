// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/sqlite_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>

namespace volute {
namespace {

using ::testing::HasSubstr;

constexpr std::size_t kPage = 512;

void put(std::string& bytes, std::size_t at, std::uint64_t value, int count) {
  for (int i = 0; i < count; ++i)
    bytes[at + static_cast<std::size_t>(i)] = static_cast<char>(value >> (8 * (count - 1 - i)));
}

/// Numbers are whole with eight bytes, or floating; text up to 50 letters.
std::string recordOf(const std::vector<SqliteFile::Value>& row) {
  std::string types, body;
  for (const auto& value : row) {
    std::string bytes(8, '\0');
    if (const auto* whole = std::get_if<std::int64_t>(&value)) {
      types += '\6';
      put(bytes, 0, static_cast<std::uint64_t>(*whole), 8);
    } else if (const auto* number = std::get_if<double>(&value)) {
      types += '\7';
      put(bytes, 0, std::bit_cast<std::uint64_t>(*number), 8);
    } else if (const auto* text = std::get_if<std::string>(&value)) {
      types += static_cast<char>(13 + 2 * text->size());
      bytes = *text;
    } else {
      types += '\0';
      bytes.clear();
    }
    body += bytes;
  }
  return static_cast<char>(types.size() + 1) + types + body;
}

/// A page with all rows.
std::string pageOf(const std::vector<std::vector<SqliteFile::Value>>& rows, std::size_t head) {
  std::string page(kPage, '\0');
  page[head] = 0x0D;
  put(page, head + 3, rows.size(), 2);
  std::size_t end = kPage;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::string record = recordOf(rows[i]);
    const std::string cell =
        std::string{static_cast<char>(record.size()), static_cast<char>(i + 1)} + record;
    end -= cell.size();
    page.replace(end, cell.size(), cell);
    put(page, head + 8 + 2 * i, end, 2);
  }
  return page;
}

std::string database() {
  std::string first = pageOf(
      {{"table", "walk", "walk", std::int64_t{2}, "CREATE TABLE walk(id, \"x y\" REAL)"}}, 100);
  first.replace(0, 16, std::string("SQLite format 3\0", 16));
  put(first, 16, kPage, 2);
  put(first, 28, 2, 4);
  put(first, 56, 1, 4);
  return first + pageOf({{std::int64_t{7}, 2.5}, {std::int64_t{-3}, std::int64_t{4}}}, 0);
}

Result<std::string> content(std::string_view bytes) {
  VOLUTE_ASSIGN(const auto file, SqliteFile::open(bytes, "a.sqlite"));
  std::string all;
  constexpr std::string_view kColumns[] = {"x y", "id"};
  VOLUTE_TRY(file.forEachRow("walk", kColumns, [&](auto row) -> Status {
    for (const auto& value : row) {
      if (const auto* whole = std::get_if<std::int64_t>(&value))
        all += fmt::format("{} ", *whole);
      else if (const auto* number = std::get_if<double>(&value))
        all += fmt::format("{} ", *number);
    }
    return {};
  }));
  return all;
}

TEST(SqliteFile, GivesRowsByTheNamesOfColumns) {
  EXPECT_EQ(content(database()).value(), "2.5 7 4 -3 ");
  const std::string bytes = database();
  const auto file = SqliteFile::open(bytes, "a.sqlite").value();
  constexpr std::string_view kOther[] = {"y"};
  EXPECT_THAT(file.forEachRow("walk", kOther, {}).error().message, HasSubstr("no column 'y'"));
  EXPECT_THAT(file.forEachRow("run", kOther, {}).error().message, HasSubstr("no table 'run'"));
  EXPECT_FALSE(SqliteFile::isOne("id,time\n"));
}

TEST(SqliteFile, DamageIsFoundOrHarmless) {
  const std::string whole = database();
  for (std::size_t i = 0; i < whole.size(); ++i) {
    EXPECT_FALSE(content(std::string_view(whole).substr(0, i))) << i;
    for (int bit = 0; bit < 8; ++bit) {
      std::string damaged = whole;
      damaged[i] = static_cast<char>(damaged[i] ^ (1 << bit));
      (void)content(damaged);
    }
  }
  // A page that is its own child.
  std::string ring = whole;
  ring.replace(kPage, kPage, std::string(kPage, '\0'));
  ring[kPage] = 5;
  put(ring, kPage + 8, 2, 4);
  EXPECT_THAT(content(ring).error().message, HasSubstr("page 2 of the database is damaged"));
}

}  // namespace
}  // namespace volute
