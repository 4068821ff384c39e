// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/sqlite_file.hpp"

#include <algorithm>
#include <bit>
#include <optional>

#include "volute/io/table_row.hpp"

namespace volute {
namespace {

constexpr std::string_view kSqliteMagic("SQLite format 3\0", 16);
constexpr std::size_t kHead = 100;
constexpr int kDeepest = 32;

/// Big-endian, as all of the format.
std::uint64_t numberAt(std::string_view bytes, std::size_t at, std::size_t count) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < count; ++i)
    value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
  return value;
}

/// A number of one to nine bytes, seven bits each; nothing past the end.
std::optional<std::uint64_t> varint(std::string_view bytes, std::size_t& at) {
  std::uint64_t value = 0;
  for (int i = 0; i < 9; ++i) {
    if (at >= bytes.size())
      return std::nullopt;
    const auto byte = static_cast<unsigned char>(bytes[at++]);
    if (i == 8)
      return value << 8 | byte;
    value = value << 7 | (byte & 0x7FU);
    if ((byte & 0x80U) == 0)
      return value;
  }
  return value;
}

std::string unquoted(std::string_view word) {
  if (word.size() >= 2 && std::string_view("\"'`[").find(word.front()) != std::string_view::npos)
    word = word.substr(1, word.size() - 2);
  return std::string(word);
}

/// The columns that "CREATE TABLE name (...)" names.
void readColumns(std::string_view sql, SqliteFile::Table& table) {
  const std::size_t open = sql.find('('), close = sql.rfind(')');
  if (open == sql.npos || close == sql.npos || close < open)
    return;
  std::string piece;
  int depth = 0;
  const auto end = [&] {
    const std::string_view text = trimmedField(piece);
    const std::size_t quote = std::string_view("\"'`[").find(text.empty() ? ' ' : text.front());
    const std::size_t length = quote != std::string_view::npos
                                   ? text.find("\"'`]"[quote], 1) + 1
                                   : std::min(text.find_first_of(" \t("), text.size());
    const std::string first = lowerCase(text.substr(0, length));
    const bool column = first != "primary" && first != "unique" && first != "check" &&
                        first != "foreign" && first != "constraint" && !text.empty();
    if (column) {
      if (lowerCase(text).find("integer primary key") != std::string::npos)
        table.rowId = static_cast<int>(table.columns.size());
      table.columns.push_back(unquoted(text.substr(0, length)));
    }
    piece.clear();
  };
  for (char c : sql.substr(open + 1, close - open - 1)) {
    depth += c == '(' ? 1 : c == ')' ? -1 : 0;
    c = c == '\n' || c == '\r' || c == '\t' ? ' ' : c;
    if (c == ',' && depth == 0)
      end();
    else if (c != ' ' || !piece.ends_with(' '))
      piece += c;
  }
  end();
}

}  // namespace

bool SqliteFile::isOne(std::string_view bytes) {
  return bytes.starts_with(kSqliteMagic);
}

tl::unexpected<Error> SqliteFile::damaged(std::uint32_t page) const {
  return fail(ErrorCode::kInvalidData,
              "{}: page {} of the database is damaged: copy the file again", name_, page);
}

Result<SqliteFile> SqliteFile::open(std::string_view bytes, std::string_view name) {
  SqliteFile file(bytes, name);
  if (!isOne(bytes) || bytes.size() < kHead)
    return fail(ErrorCode::kInvalidData, "{}: not an SQLite 3 database", name);
  file.pageSize_ = numberAt(bytes, 16, 2) == 1 ? 65536 : numberAt(bytes, 16, 2);
  const auto reserved = static_cast<std::size_t>(numberAt(bytes, 20, 1));
  if (file.pageSize_ < 512 || !std::has_single_bit(file.pageSize_) ||
      file.pageSize_ - reserved < 480)
    return file.damaged(1);
  file.usable_ = file.pageSize_ - reserved;
  if (numberAt(bytes, 56, 4) > 1) {
    return fail(ErrorCode::kUnsupported,
                "{}: its text is UTF-16; expected an SQLite database in UTF-8", name);
  }
  file.pages_ = static_cast<std::uint32_t>(bytes.size() / file.pageSize_);
  if (numberAt(bytes, 28, 4) > file.pages_ || file.pages_ == 0) {
    return fail(ErrorCode::kTruncated, "{}: has {} of {} pages: copy the file again", name,
                file.pages_, numberAt(bytes, 28, 4));
  }
  VOLUTE_TRY(file.readSchema());
  return file;
}

Status SqliteFile::readSchema() {
  const Table schema{"sqlite_schema", {"type", "name", "tbl_name", "rootpage", "sql"}, 1, -1};
  std::size_t budget = pages_;
  return walk(1, 0, budget, schema, [&](std::span<const Value> row) -> Status {
    const auto text = [&](std::size_t i) {
      const auto* value = i < row.size() ? std::get_if<std::string>(&row[i]) : nullptr;
      return value == nullptr ? std::string() : *value;
    };
    const auto* root = row.size() > 3 ? std::get_if<std::int64_t>(&row[3]) : nullptr;
    if (text(0) != "table" || root == nullptr || *root < 1 || *root > pages_)
      return {};
    Table table{text(1), {}, static_cast<std::uint32_t>(*root), -1};
    readColumns(text(4), table);
    tables_.push_back(std::move(table));
    return {};
  });
}

Result<std::string_view> SqliteFile::page(std::uint32_t number) const {
  if (number < 1 || number > pages_)
    return damaged(number);
  return bytes_.substr((number - 1) * pageSize_, pageSize_);
}

/// A cell's content, the beginning of which is at `at` and the rest on pages of its own.
Result<std::string> SqliteFile::payload(std::string_view page, std::uint32_t number, std::size_t at,
                                        std::uint64_t size) const {
  if (size > bytes_.size())
    return damaged(number);
  const std::size_t most = usable_ - 35;
  const std::size_t least = (usable_ - 12) * 32 / 255 - 23;
  std::size_t local = size;
  if (size > most) {
    local = least + (size - least) % (usable_ - 4);
    local = local <= most ? local : least;
  }
  if (at + local + (size > local ? 4 : 0) > usable_)
    return damaged(number);
  std::string out(page.substr(at, local));
  auto next = size > local ? static_cast<std::uint32_t>(numberAt(page, at + local, 4)) : 0U;
  while (out.size() < size) {
    VOLUTE_ASSIGN(const std::string_view more, this->page(next));
    out += more.substr(4, std::min<std::size_t>(usable_ - 4, size - out.size()));
    next = static_cast<std::uint32_t>(numberAt(more, 0, 4));
  }
  return out;
}

Result<std::vector<SqliteFile::Value>> SqliteFile::record(std::string_view payload,
                                                          std::uint32_t number) const {
  std::vector<Value> values;
  std::size_t at = 0;
  const auto head = varint(payload, at);
  if (!head || *head > payload.size())
    return damaged(number);
  std::size_t body = *head;
  while (at < *head) {
    const auto type = varint(payload, at);
    if (!type)
      return damaged(number);
    constexpr std::size_t kSizes[] = {0, 1, 2, 3, 4, 6, 8, 8, 0, 0, 0, 0};
    const std::size_t size = *type < 12 ? kSizes[*type] : (*type - 12) / 2;
    if (size > payload.size() - body)
      return damaged(number);
    const auto raw = *type < 12 ? numberAt(payload, body, size) : 0;
    if (*type == 0 || *type == 10 || *type == 11)
      values.emplace_back();
    else if (*type == 7)
      values.emplace_back(std::bit_cast<double>(raw));
    else if (*type == 8 || *type == 9)
      values.emplace_back(static_cast<std::int64_t>(*type - 8));
    else if (*type < 12)
      values.emplace_back(static_cast<std::int64_t>(raw << (64 - 8 * size)) >> (64 - 8 * size));
    else
      values.emplace_back(std::string(payload.substr(body, size)));
    body += size;
  }
  return values;
}

/// The rows below a page. `budget` counts the pages that may still be read: a ring ends there.
Status SqliteFile::walk(std::uint32_t number, int depth, std::size_t& budget, const Table& table,
                        const Visit& visit) const {
  if (depth > kDeepest || budget-- == 0)
    return damaged(number);
  VOLUTE_ASSIGN(const std::string_view bytes, page(number));
  const std::size_t head = number == 1 ? kHead : 0;
  const auto kind = numberAt(bytes, head, 1);
  const bool leaf = kind == 0x0D;
  if (!leaf && kind != 0x05) {
    return fail(ErrorCode::kUnsupported,
                "{}: table '{}' is not an ordinary one (WITHOUT ROWID, or the file is damaged)",
                name_, table.name);
  }
  const auto cells = static_cast<std::size_t>(numberAt(bytes, head + 3, 2));
  const std::size_t list = head + (leaf ? 8 : 12);
  if (list + 2 * cells > usable_)
    return damaged(number);
  for (std::size_t i = 0; i < cells; ++i) {
    auto at = static_cast<std::size_t>(numberAt(bytes, list + 2 * i, 2));
    if (at + 4 > usable_)
      return damaged(number);
    if (!leaf) {
      VOLUTE_TRY(walk(static_cast<std::uint32_t>(numberAt(bytes, at, 4)), depth + 1, budget, table,
                      visit));
      continue;
    }
    const auto size = varint(bytes, at);
    const auto id = varint(bytes, at);
    if (!size || !id)
      return damaged(number);
    VOLUTE_ASSIGN(const std::string content, payload(bytes, number, at, *size));
    VOLUTE_ASSIGN(auto row, record(content, number));
    if (table.rowId >= 0 && static_cast<std::size_t>(table.rowId) < row.size())
      row[static_cast<std::size_t>(table.rowId)] = static_cast<std::int64_t>(*id);
    VOLUTE_TRY(visit(row));
  }
  if (leaf)
    return {};
  return walk(static_cast<std::uint32_t>(numberAt(bytes, head + 8, 4)), depth + 1, budget, table,
              visit);
}

Status SqliteFile::forEachRow(std::string_view table, std::span<const std::string_view> columns,
                              const Visit& visit) const {
  const auto found = std::ranges::find(tables_, table, &Table::name);
  if (found == tables_.end())
    return fail(ErrorCode::kNotFound, "{}: has no table '{}'", name_, table);
  std::vector<std::size_t> places;
  for (const std::string_view column : columns) {
    const auto place = std::ranges::find(found->columns, column);
    if (place == found->columns.end())
      return fail(ErrorCode::kNotFound, "{}: table '{}' has no column '{}'", name_, table, column);
    places.push_back(static_cast<std::size_t>(place - found->columns.begin()));
  }
  std::vector<Value> wanted(places.size());
  std::size_t budget = pages_;
  return walk(found->root, 0, budget, *found, [&](std::span<const Value> row) {
    for (std::size_t i = 0; i < places.size(); ++i)
      wanted[i] = places[i] < row.size() ? row[places[i]] : Value();
    return visit(wanted);
  });
}

}  // namespace volute
