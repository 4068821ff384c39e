// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/grid_table.hpp"

#include <algorithm>
#include <cmath>

namespace volute {
namespace {

enum GridFlags : std::uint8_t { kEmptyGrid = 1, kDescribedGrid = 2 };

constexpr std::size_t kMaxTiers = 5;

void writeMetadata(ByteWriter& out, const FrameMetadata& metadata) {
  out.varint(metadata.lists.size());
  for (const MetadataList& list : metadata.lists) {
    out.varint(list.size());
    for (const GridMetadata& entry : list) {
      out.string(entry.name);
      out.string(entry.type);
      out.string(entry.value);
    }
  }
  out.varint(metadata.listOf.size());
  for (const int list : metadata.listOf) out.varint(static_cast<std::uint64_t>(list + 1));
}

// Each list, entry and frame takes a byte at least.
bool readMetadata(ByteReader& in, FrameMetadata& metadata) {
  const std::uint64_t lists = in.varint();
  if (!in.ok() || lists > in.remaining())
    return false;
  for (std::uint64_t i = 0; i < lists; ++i) {
    const std::uint64_t entries = in.varint();
    if (!in.ok() || entries > in.remaining())
      return false;
    MetadataList& list = metadata.lists.emplace_back();
    for (std::uint64_t k = 0; k < entries; ++k) {
      GridMetadata& entry = list.emplace_back();
      for (std::string* text : {&entry.name, &entry.type, &entry.value}) *text = in.string();
      if (!in.ok())
        return false;
    }
  }
  const std::uint64_t frames = in.varint();
  if (!in.ok() || frames > in.remaining())
    return false;
  for (std::uint64_t i = 0; i < frames; ++i) {
    const std::uint64_t list = in.varint();
    if (list > lists)
      return false;
    metadata.listOf.push_back(static_cast<int>(list) - 1);
  }
  return in.ok();
}

void writeIndex(ByteWriter& out, const GridDescription::Index& index) {
  for (const std::int64_t number : index) out.zigzag(number);
}

bool readIndex(ByteReader& in, GridDescription::Index& index) {
  constexpr std::int64_t kFarthest = std::int64_t{1} << 40;
  for (std::int64_t& number : index) {
    number = in.zigzag();
    if (number < -kFarthest || number > kFarthest)
      return false;
  }
  return in.ok();
}

void writeDescription(ByteWriter& out, const GridDescription& grid) {
  out.string(grid.type);
  out.string(grid.gridClass);
  out.u8(grid.half ? 1 : 0);
  for (const double value : grid.background) out.f64(value);
  out.string(grid.map);
  for (const auto& numbers : {grid.voxelSize, grid.origin})
    for (const double number : numbers) out.f64(number);
  writeIndex(out, grid.begin);
  out.varint(grid.voxels);
  out.varint(grid.memory);
  writeMetadata(out, grid.metadata);
  out.varint(grid.shifts.size());
  for (const auto& shift : grid.shifts) writeIndex(out, shift);
  if (grid.matrices.empty())
    return;
  out.varint(grid.matrices.size());
  for (const GridMatrix& matrix : grid.matrices)
    for (const double number : matrix) out.f64(number);
}

bool readDescription(ByteReader& in, GridDescription& grid) {
  grid.type = in.string();
  grid.gridClass = in.string();
  const int half = in.u8();
  grid.half = half == 1;
  for (double& value : grid.background) value = in.f64();
  grid.map = in.string();
  for (auto* numbers : {&grid.voxelSize, &grid.origin})
    for (double& number : *numbers) number = in.f64();
  const auto finite = [](double number) { return std::isfinite(number); };
  if (half > 1 || !std::ranges::all_of(grid.voxelSize, finite) ||
      !std::ranges::all_of(grid.origin, finite) || !std::ranges::all_of(grid.background, finite) ||
      !readIndex(in, grid.begin))
    return false;
  grid.voxels = in.varint();
  grid.memory = in.varint();
  if (!readMetadata(in, grid.metadata))
    return false;
  const std::uint64_t shifts = in.varint();
  if (!in.ok() || shifts > in.remaining())
    return false;
  for (std::uint64_t i = 0; i < shifts; ++i) {
    if (!readIndex(in, grid.shifts.emplace_back()))
      return false;
  }
  if (!in.ok() || in.remaining() == 0)
    return in.ok();
  const std::uint64_t matrices = in.varint();
  if (!in.ok() || matrices > in.remaining() / sizeof(GridMatrix) || (matrices > 0 && shifts > 0))
    return false;
  for (std::uint64_t i = 0; i < matrices; ++i) {
    GridMatrix& matrix = grid.matrices.emplace_back();
    for (double& number : matrix) number = in.f64();
    if (!isSound(matrix))
      return false;
  }
  const auto sized = [](double size) { return size > 0; };
  return in.ok() && (matrices == 0 || std::ranges::all_of(grid.voxelSize, sized));
}

bool readRow(ByteReader& in, bool paged, GridRow& row) {
  row.name = in.string();
  const int flags = in.u8();
  if (!in.ok() || flags > (kEmptyGrid | kDescribedGrid))
    return false;
  row.empty = (flags & kEmptyGrid) != 0;
  const std::uint64_t tiers = in.varint();
  if (!in.ok() || tiers > kMaxTiers || row.empty != (tiers == 0))
    return false;
  for (std::uint64_t i = 0; i < tiers; ++i) {
    row.tierBytes.push_back(in.varint());
    if (row.tierBytes.back() >= std::uint64_t{1} << 56)  // so that sums do not overflow
      return false;
  }
  row.pageBytes = paged && !row.empty ? in.varint() : 0;
  if ((flags & kDescribedGrid) == 0)
    return in.ok();
  // Bytes after what is read are for later minor versions.
  ByteReader description(in.bytes(in.varint()));
  return in.ok() && readDescription(description, row.description.emplace());
}

}  // namespace

std::vector<std::byte> writeGridTable(const GridTable& table) {
  ByteWriter out;
  out.varint(table.rows.size());
  for (const GridRow& row : table.rows) {
    out.string(row.name);
    out.u8(static_cast<std::uint8_t>((row.empty ? kEmptyGrid : 0) |
                                     (row.description ? kDescribedGrid : 0)));
    out.varint(row.tierBytes.size());
    for (const std::uint64_t bytes : row.tierBytes) out.varint(bytes);
    if (table.paged && !row.empty)
      out.varint(row.pageBytes);
    if (!row.description)
      continue;
    ByteWriter description;
    writeDescription(description, *row.description);
    out.varint(description.size());
    out.bytes(description.view());
  }
  writeMetadata(out, table.fileMetadata);
  return out.take();
}

Result<GridTable> readGridTable(std::span<const std::byte> content, bool paged) {
  ByteReader in(content);
  GridTable table;
  table.paged = paged;
  const std::uint64_t rows = in.varint();
  // Codec 2 has a grid with values in every file.
  if (!in.ok() || (rows == 0 && !paged) || rows > in.remaining())
    return fail(ErrorCode::kInvalidData, "the number of grids");
  for (std::uint64_t i = 0; i < rows; ++i) {
    if (!readRow(in, paged, table.rows.emplace_back()))
      return fail(ErrorCode::kInvalidData, "grid {}", i + 1);
  }
  std::vector<std::string_view> names;
  for (const GridRow& row : table.rows) names.push_back(row.name);
  std::ranges::sort(names);
  if (std::ranges::adjacent_find(names) != names.end())
    return fail(ErrorCode::kInvalidData, "two grids with one name");
  if (!paged && std::ranges::all_of(table.rows, &GridRow::empty))
    return fail(ErrorCode::kInvalidData, "all grids are empty");
  if (!readMetadata(in, table.fileMetadata))
    return fail(ErrorCode::kInvalidData, "what its files say of themselves");
  return table;
}

}  // namespace volute
