// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "volute/base/output_file.hpp"
#include "volute/base/result.hpp"
#include "volute/codec/block_index.hpp"
#include "volute/codec/spool.hpp"
#include "volute/grid/kept_bytes.hpp"

namespace volute {

/// A grid that a file holds as its bytes.
struct KeptGrid {
  std::string name;
  std::string type;           ///< of a value: "int32", "bool", "mask"
  std::size_t place = 0;      ///< how many of the coded grids stand before it
  std::vector<int> pieces{};  ///< of each frame, in KeptTable::pieceBytes; -1: it has none

  bool operator==(const KeptGrid&) const = default;
};

/// All that a file keeps without decoding it (docs/format.md, section 4.5).
struct KeptTable {
  std::vector<KeptGrid> grids{};
  std::vector<std::uint64_t> pieceBytes{};  ///< of each piece: its bytes, not packed
  std::vector<SegmentEntry> parts{};        ///< packed, KeptBytes::kPart bytes each, in order

  /// That the parts take in the file.
  std::uint64_t storedBytes() const;

  /// Bytes that one grid takes in the file.
  std::uint64_t storedBytes(std::size_t grid) const;

  /// Where the parts are that follow each other from `offset` on.
  void place(std::uint64_t offset);

  /// The first part of a piece, and that of the one behind it.
  std::pair<std::size_t, std::size_t> partsOf(int piece) const;
};

/// The content of a KEEP chunk.
std::vector<std::byte> writeKeptTable(const KeptTable& table);

/// Takes any bytes: what it allocates is in proportion to them. The lists of pieces have the length
/// that the bytes state, which the caller compares with the frames that there are.
[[nodiscard]] Result<KeptTable> readKeptTable(std::span<const std::byte> content);

/// The kept grids of a file in the making; their bytes wait in a file without a name.
class KeptStore {
 public:
  /// In the folder of `target`.
  [[nodiscard]] static Result<KeptStore> create(const std::filesystem::path& target);

  /// Begins a grid, whose frames follow.
  void begin(KeptGrid grid) { table_.grids.push_back(std::move(grid)); }

  /// The next frame of the grid; null: it has none. What equals the frame before is stored once.
  [[nodiscard]] Status add(KeptBytes* bytes);

  const KeptTable& table() const { return table_; }

  [[nodiscard]] Status copyTo(OutputFile& out);

 private:
  explicit KeptStore(Spool spool) : spool_(std::move(spool)) {}

  Result<bool> equals(int piece, std::size_t first, std::uint64_t offset, std::uint64_t bytes);

  Spool spool_;
  KeptTable table_;
};

}  // namespace volute
