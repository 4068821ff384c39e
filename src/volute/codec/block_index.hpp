// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "volute/base/input_file.hpp"
#include "volute/base/result.hpp"
#include "volute/codec/block_codec.hpp"
#include "volute/codec/block_grid.hpp"
#include "volute/grid/bricks.hpp"

namespace volute {

/// Where one tier of one block lies in the file.
struct SegmentEntry {
  std::uint64_t offset = 0;
  std::uint32_t size = 0;
  std::uint32_t crc = 0;  ///< codec 3 has it behind the bytes of a segment; 0 in what is read of it
};

/// The tiles of each frame.
using FrameTiles = std::vector<std::vector<Bricks::Tile>>;

/// Most tiers that a block may have.
inline constexpr std::size_t kMaxBlockTiers = 5;

/// A piece of the index of codec 3 (docs/format.md, section 6): blocks that follow one another.
struct IndexPage {
  std::uint64_t offset = 0;  ///< of its bytes in the file
  std::uint32_t bytes = 0, crc = 0;
  std::uint64_t firstBlock = 0, blocks = 0;
  /// Where the segments of its blocks stand: in each tier one after the other.
  std::array<std::uint64_t, kMaxBlockTiers> begins{}, sizes{};
};

/// Tiles of some rows of frames.
struct TilePage {
  std::uint64_t offset = 0;
  std::uint32_t bytes = 0, crc = 0;
  int firstRow = 0;  ///< up to that of the next
};

/// The content of an INDX chunk of codec 3.
struct PageTable {
  std::vector<TilePage> tiles{};
  std::vector<IndexPage> pages{};  ///< ascending

  /// Bytes of all.
  std::uint64_t bytes() const;
};

/// What is in a page of the index.
struct PageContent {
  std::vector<std::uint64_t> blocks;   ///< ascending
  std::vector<SegmentEntry> segments;  ///< tier by tier
  std::vector<std::int64_t> means{};   ///< block by block, of each channel; or none
};

/// The pages of a grid, and the chunk that lists them.
struct WrittenPages {
  std::vector<std::byte> chunk, pages;
};

/// @param frames  of a row of blocks
WrittenPages writePages(const PageContent& content, std::size_t tiers, const FrameTiles& tiles,
                        int channels, int frames);

/// Where the segments of one tier of one grid stand.
struct TierPlace {
  std::uint64_t begin = 0, bytes = 0;
};

/// Accepts any bytes; the message of an error lacks the name of the file.
/// @param content  of the chunk
/// @param begin    of the grid's pages
/// @param places   of its tiers; none: they follow one another from the last page on
[[nodiscard]] Result<PageTable> readPageTable(std::span<const std::byte> content,
                                              const BlockGrid& grid, std::size_t tiers,
                                              std::uint64_t begin,
                                              std::span<const TierPlace> places);

/// Reads a page and checks it. Allocates in proportion to its bytes.
[[nodiscard]] Result<PageContent> readIndexPage(const InputFile& file, const IndexPage& page,
                                                const BlockGrid& grid, const BlockDecoder& decoder);

/// The tiles of rows firstRow up to (not including) endRow, one list for each frame.
/// @param budget  bytes that they may take
[[nodiscard]] Result<FrameTiles> readTilePage(const InputFile& file, const TilePage& page,
                                              int endRow, const BlockGrid& grid,
                                              std::uint64_t budget);

/// The bytes of a segment of codec 3 from those of its values.
void appendChecksum(std::vector<std::byte>& values);

/// Whether the checksum of a segment of codec 3 is right.
bool isIntact(std::span<const std::byte> segment);

}  // namespace volute
