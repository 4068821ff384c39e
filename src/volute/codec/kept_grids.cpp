// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/kept_grids.hpp"

#include <algorithm>
#include <numeric>
#include <set>

#include "volute/base/checksum.hpp"
#include "volute/codec/byte_io.hpp"
#include "volute/codec/packing.hpp"

namespace volute {
namespace {

std::size_t partsIn(std::uint64_t bytes) {
  return static_cast<std::size_t>((bytes + KeptBytes::kPart - 1) / KeptBytes::kPart);
}

}  // namespace

std::uint64_t KeptTable::storedBytes() const {
  return std::accumulate(
      parts.begin(), parts.end(), std::uint64_t{0},
      [](std::uint64_t sum, const SegmentEntry& part) { return sum + part.size; });
}

std::uint64_t KeptTable::storedBytes(std::size_t grid) const {
  const std::set<int> pieces(grids[grid].pieces.begin(), grids[grid].pieces.end());
  std::uint64_t bytes = 0;
  for (const int piece : pieces) {
    if (piece < 0)
      continue;
    const auto [first, end] = partsOf(piece);
    for (std::size_t part = first; part < end; ++part) bytes += parts[part].size;
  }
  return bytes;
}

void KeptTable::place(std::uint64_t offset) {
  for (SegmentEntry& part : parts) {
    part.offset = offset;
    offset += part.size;
  }
}

std::pair<std::size_t, std::size_t> KeptTable::partsOf(int piece) const {
  const auto at = pieceBytes.begin() + piece;
  const std::size_t first =
      std::accumulate(pieceBytes.begin(), at, std::size_t{0},
                      [](std::size_t sum, std::uint64_t bytes) { return sum + partsIn(bytes); });
  return {first, first + partsIn(*at)};
}

std::vector<std::byte> writeKeptTable(const KeptTable& table) {
  ByteWriter out;
  out.varint(table.grids.size());
  for (const KeptGrid& grid : table.grids) {
    out.string(grid.name);
    out.string(grid.type);
    out.varint(grid.place);
    out.varint(grid.pieces.size());
    for (const int piece : grid.pieces) out.varint(static_cast<std::uint64_t>(piece + 1));
  }
  out.varint(table.pieceBytes.size());
  for (const std::uint64_t bytes : table.pieceBytes) out.varint(bytes);
  for (const SegmentEntry& part : table.parts) {
    out.varint(part.size);
    out.u32(part.crc);
  }
  return out.take();
}

Result<KeptTable> readKeptTable(std::span<const std::byte> content) {
  constexpr std::size_t kPartEntry = 1 + 4;
  constexpr std::uint64_t kMaxPacked = KeptBytes::kPart + 1;
  const auto malformed = [](std::string_view what) {
    return fail(ErrorCode::kInvalidData, "the table of kept grids is malformed: {}", what);
  };
  ByteReader in(content);
  KeptTable table;
  const std::uint64_t grids = in.varint();
  if (!in.ok() || grids > in.remaining())
    return malformed("the number of grids");
  for (std::uint64_t i = 0; i < grids; ++i) {
    KeptGrid& grid = table.grids.emplace_back();
    grid.name = in.string();
    grid.type = in.string();
    grid.place = static_cast<std::size_t>(in.varint());
    const std::uint64_t frames = in.varint();
    if (!in.ok() || frames > in.remaining())
      return malformed("a grid");
    for (std::uint64_t k = 0; k < frames; ++k)
      grid.pieces.push_back(
          static_cast<int>(std::min<std::uint64_t>(in.varint(), content.size() + 1)) - 1);
  }
  const std::uint64_t pieces = in.varint();
  if (!in.ok() || pieces > in.remaining())
    return malformed("the number of pieces");
  std::uint64_t parts = 0;
  for (std::uint64_t i = 0; i < pieces; ++i) {
    const std::uint64_t bytes = in.varint();
    if (!in.ok() || bytes == 0 || (parts += partsIn(bytes)) > in.remaining() / kPartEntry ||
        bytes > in.remaining() * KeptBytes::kPart)
      return malformed("the size of a piece");
    table.pieceBytes.push_back(bytes);
  }
  for (std::uint64_t i = 0; i < parts; ++i) {
    const std::uint64_t size = in.varint();
    const std::uint32_t crc = in.u32();
    if (!in.ok() || size == 0 || size > kMaxPacked)
      return malformed("the size of a part");
    table.parts.push_back({0, static_cast<std::uint32_t>(size), crc});
  }
  for (const KeptGrid& grid : table.grids)
    for (const int piece : grid.pieces) {
      if (piece >= static_cast<int>(table.pieceBytes.size()))
        return malformed("a piece that is not there");
    }
  return table;
}

Result<KeptStore> KeptStore::create(const std::filesystem::path& target) {
  const auto folder = target.parent_path();
  VOLUTE_ASSIGN(auto spool, Spool::create(folder.empty() ? "." : folder));
  return KeptStore(std::move(spool));
}

Status KeptStore::add(KeptBytes* bytes) {
  KeptGrid& grid = table_.grids.back();
  if (bytes == nullptr) {
    grid.pieces.push_back(-1);
    return {};
  }
  const std::size_t first = table_.parts.size();
  const std::uint64_t offset = spool_.size();
  for (;;) {
    VOLUTE_ASSIGN(const auto part, bytes->next());
    if (part.empty())
      break;
    const auto packed = pack({part});
    table_.parts.push_back(
        {spool_.size(), static_cast<std::uint32_t>(packed.size()), crc32(packed)});
    VOLUTE_TRY(spool_.write(packed));
  }
  const int before = grid.pieces.empty() ? -1 : grid.pieces.back();
  if (before >= 0) {
    VOLUTE_ASSIGN(const bool same, equals(before, first, offset, bytes->size()));
    if (same) {
      table_.parts.resize(first);
      grid.pieces.push_back(before);
      return {};
    }
  }
  grid.pieces.push_back(static_cast<int>(table_.pieceBytes.size()));
  table_.pieceBytes.push_back(bytes->size());
  return {};
}

/// Whether a piece has these bytes, whose parts begin at `first` and `offset`.
Result<bool> KeptStore::equals(int piece, std::size_t first, std::uint64_t offset,
                               std::uint64_t bytes) {
  const auto [begin, end] = table_.partsOf(piece);
  if (table_.pieceBytes[static_cast<std::size_t>(piece)] != bytes ||
      end - begin != table_.parts.size() - first)
    return false;
  std::vector<std::byte> one, other;
  for (std::size_t i = begin; i < end; ++i) {
    const SegmentEntry &a = table_.parts[i], &b = table_.parts[first + i - begin];
    if (a.size != b.size || a.crc != b.crc)
      return false;
    one.resize(a.size), other.resize(b.size);
    VOLUTE_TRY(spool_.read(a.offset, one));
    VOLUTE_TRY(spool_.read(offset, other));
    if (one != other)
      return false;
    offset += b.size;
  }
  return true;
}

Status KeptStore::copyTo(OutputFile& out) {
  std::vector<std::byte> bytes;
  for (const SegmentEntry& part : table_.parts) {
    bytes.resize(part.size);
    VOLUTE_TRY(spool_.read(part.offset, bytes));
    VOLUTE_TRY(out.write(bytes));
  }
  return {};
}

}  // namespace volute
