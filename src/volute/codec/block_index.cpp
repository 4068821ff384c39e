// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/block_index.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "volute/base/checksum.hpp"
#include "volute/codec/byte_io.hpp"
#include "volute/codec/container.hpp"
#include "volute/codec/packing.hpp"

namespace volute {
namespace {

// A page of the index has at least so many blocks; of many blocks so many more that neither the
// list of pages nor a page is much larger than the other.
constexpr std::size_t kBlocksAPage = 1024;
constexpr std::size_t kTilesAPage = 1024;
// A number and the size of a tier, varints, take so many bytes at most.
constexpr std::uint64_t kNumberBytes = 10, kSizeBytes = 5;
constexpr std::uint64_t kChecksumBytes = 4;

std::size_t blocksAPage(std::size_t blocks) {
  constexpr double kEntryToBlock = 2.25;  // bytes of a page in the list to those of a block
  return std::max(kBlocksAPage,
                  static_cast<std::size_t>(std::sqrt(kEntryToBlock * static_cast<double>(blocks))));
}

// A tile's place from the one before, and its value where that is another.
void writeTiles(ByteWriter& out, std::span<const Bricks::Tile> tiles, std::size_t channels) {
  out.varint(tiles.size());
  Bricks::Tile before;
  for (const Bricks::Tile& tile : tiles) {
    const bool same =
        std::equal(tile.value.begin(), tile.value.begin() + static_cast<std::ptrdiff_t>(channels),
                   before.value.begin());
    const auto size =
        static_cast<unsigned>(std::countr_zero(static_cast<std::uint64_t>(tile.side)));
    out.u8(static_cast<std::uint8_t>(size << 2 | (tile.active ? 2u : 0u) | (same ? 1u : 0u)));
    for (std::size_t axis = 0; axis < 3; ++axis)
      out.zigzag(tile.origin[axis] - before.origin[axis]);
    for (std::size_t c = 0; !same && c < channels; ++c) out.f32(tile.value[c]);
    before = tile;
  }
}

Result<std::vector<Bricks::Tile>> readTiles(ByteReader& in, std::size_t channels,
                                            std::uint64_t& budget) {
  constexpr std::int64_t kFarthest = std::int64_t{1} << 40;
  const std::uint64_t count = in.varint();
  if (!in.ok() || count > in.remaining())
    return fail(ErrorCode::kInvalidData, "the number of tiles");
  if (count > budget / sizeof(Bricks::Tile))
    return fail(ErrorCode::kTooLarge, "its tiles take more memory than is allowed");
  budget -= count * sizeof(Bricks::Tile);
  std::vector<Bricks::Tile> tiles;
  Bricks::Tile tile;
  for (std::uint64_t i = 0; i < count; ++i) {
    const unsigned what = in.u8();
    if ((what >> 2) < 3 || (what >> 2) > 30)
      return fail(ErrorCode::kInvalidData, "the size of a tile");
    tile.side = std::int64_t{1} << (what >> 2);
    tile.active = (what & 2) != 0;
    for (std::int64_t& place : tile.origin) {
      const std::int64_t step = in.zigzag();
      if (step < -2 * kFarthest || step > 2 * kFarthest || (place += step) < -kFarthest ||
          place > kFarthest)
        return fail(ErrorCode::kInvalidData, "the place of a tile");
    }
    for (std::size_t c = 0; (what & 1) == 0 && c < channels; ++c) {
      tile.value[c] = in.f32();
      if (!std::isfinite(tile.value[c]))
        return fail(ErrorCode::kInvalidData, "the value of a tile");
    }
    if (!in.ok())
      return fail(ErrorCode::kInvalidData, "it ends early");
    tiles.push_back(tile);
  }
  return tiles;
}

// Appends a page; gives its place in the list of pages.
void append(ByteWriter& list, ByteWriter& pages, const ByteWriter& content) {
  const std::vector<std::byte> packed = pack({content.view()});
  list.varint(packed.size());
  list.u32(crc32(packed));
  pages.bytes(packed);
}

Result<std::vector<std::byte>> readPage(const InputFile& file, std::uint64_t offset,
                                        std::uint32_t size, std::uint32_t crc,
                                        std::uint64_t limit) {
  if (offset + size > file.size()) {
    return fail(ErrorCode::kTruncated, "{}: ends at byte {} inside its index, before byte {}",
                file.path().string(), file.size(), offset + size);
  }
  std::vector<std::byte> bytes(size);
  VOLUTE_TRY(file.read(offset, bytes));
  if (!checksumMatches(bytes, crc)) {
    return fail(ErrorCode::kInvalidData,
                "{}: the page of its index at byte {} is damaged: its checksum is wrong",
                file.path().string(), offset);
  }
  auto content = unpack(bytes, limit);
  if (!content)
    return fail(content.error().code, content.error().hints,
                "{}: the page of its index at byte {} {}", file.path().string(), offset,
                content.error().message);
  return content;
}

}  // namespace

std::uint64_t PageTable::bytes() const {
  std::uint64_t sum = 0;
  for (const TilePage& page : tiles) sum += page.bytes;
  for (const IndexPage& page : pages) sum += page.bytes;
  return sum;
}

WrittenPages writePages(const PageContent& all, std::size_t tiers, const FrameTiles& tiles,
                        int channels, int frames) {
  const std::span<const std::uint64_t> blocks = all.blocks;
  ByteWriter pages, tileList, blockList;
  std::size_t tilePages = 0, blockPages = 0;
  const auto framesARow = static_cast<std::size_t>(frames);
  const std::size_t rows = (tiles.size() + framesARow - 1) / framesARow;
  const auto tilesOf = [&](std::size_t row) {
    const std::size_t first = row * framesARow;
    return std::span(tiles).subspan(first, std::min(framesARow, tiles.size() - first));
  };
  for (std::size_t row = 0, before = 0; row < rows;) {
    ByteWriter content;
    std::size_t count = 0;
    std::size_t end = row;
    for (; end < rows && count < kTilesAPage; ++end) {
      for (const auto& frame : tilesOf(end)) {
        count += frame.size();
        writeTiles(content, frame, static_cast<std::size_t>(channels));
      }
    }
    // Without any there is no page, unless the one before would reach over these frames.
    if (count > 0 || tilePages > 0) {
      tileList.varint(row - before);
      append(tileList, pages, content);
      ++tilePages;
      before = row;
    }
    row = end;
  }
  const std::size_t most = blocksAPage(blocks.size());
  std::uint64_t before = 0;
  for (std::size_t first = 0; first < blocks.size(); first += most) {
    const std::size_t count = std::min(most, blocks.size() - first);
    ByteWriter content;
    for (std::size_t i = first + 1; i < first + count; ++i)
      content.varint(blocks[i] - blocks[i - 1]);
    std::array<std::uint64_t, kMaxBlockTiers> sizes{};
    for (std::size_t tier = 0; tier < tiers; ++tier) {
      for (std::size_t i = first; i < first + count; ++i) {
        const std::uint32_t size = all.segments[tier * blocks.size() + i].size;
        content.varint(size);
        sizes[tier] += size;
      }
    }
    const std::size_t meansABlock = all.means.size() / blocks.size();
    for (std::size_t c = 0; c < meansABlock; ++c) {
      std::int64_t last = 0;
      for (std::size_t i = first; i < first + count; ++i) {
        const std::int64_t mean = all.means[i * meansABlock + c];
        content.zigzag(mean - last);
        last = mean;
      }
    }
    blockList.varint(blocks[first] - before);
    before = blocks[first];
    blockList.varint(count);
    append(blockList, pages, content);
    for (std::size_t tier = 0; tier < tiers; ++tier) blockList.varint(sizes[tier]);
    ++blockPages;
  }
  ByteWriter chunk;
  chunk.varint(tilePages);
  chunk.bytes(tileList.view());
  chunk.varint(blockPages);
  chunk.bytes(blockList.view());
  return {pack({chunk.view()}), pages.take()};
}

Result<PageTable> readPageTable(std::span<const std::byte> content, const BlockGrid& grid,
                                std::size_t tiers, std::uint64_t begin,
                                std::span<const TierPlace> places) {
  // No file is so long that sums of these overflow.
  constexpr std::uint64_t kMaxBytes = std::uint64_t{1} << 56;
  const auto wrong = [](std::string_view what) {
    return fail(ErrorCode::kInvalidData, "{}", what);
  };
  PageTable table;
  ByteReader in(content);
  std::uint64_t offset = begin;
  const auto readPlace = [&](auto& page) {
    const std::uint64_t bytes = in.varint();
    page.offset = offset;
    page.bytes = static_cast<std::uint32_t>(bytes);
    page.crc = in.u32();
    offset += page.bytes;
    return in.ok() && bytes > 0 && bytes <= std::numeric_limits<std::uint32_t>::max();
  };
  const std::uint64_t tilePages = in.varint();
  if (!in.ok() || tilePages > in.remaining())
    return wrong("an impossible number of pages");
  const auto rows = static_cast<std::uint64_t>(grid.counts()[0]);
  std::uint64_t row = 0;
  for (std::uint64_t i = 0; i < tilePages; ++i) {
    const std::uint64_t step = in.varint();
    if (!in.ok() || step >= rows - row || (i > 0 && step == 0))
      return wrong("tiles of frames that cannot be");
    row += step;
    TilePage& page = table.tiles.emplace_back();
    page.firstRow = static_cast<int>(row);
    if (!readPlace(page))
      return wrong("a page of tiles that cannot be");
  }
  const std::uint64_t pages = in.varint();
  if (!in.ok() || pages > in.remaining())
    return wrong("an impossible number of pages");
  std::uint64_t next = 0;  // the least number that a block may have
  for (std::uint64_t i = 0; i < pages; ++i) {
    IndexPage& page = table.pages.emplace_back();
    const std::uint64_t step = in.varint();
    page.firstBlock = i > 0 ? table.pages[static_cast<std::size_t>(i - 1)].firstBlock + step : step;
    page.blocks = in.varint();
    if (!in.ok() || step >= grid.count() || page.firstBlock < next ||
        page.firstBlock >= grid.count() || page.blocks == 0 ||
        page.blocks > grid.count() - page.firstBlock || !readPlace(page))
      return wrong("a page of blocks that cannot be");
    next = page.firstBlock + page.blocks;
    for (std::size_t tier = 0; tier < tiers; ++tier) {
      page.sizes[tier] = in.varint();
      if (page.sizes[tier] > kMaxBytes)
        return wrong("an impossible size");
    }
  }
  if (!in.ok() || in.remaining() != 0)
    return wrong("more or less than its pages");
  std::uint64_t at = offset;
  for (std::size_t tier = 0; tier < tiers; ++tier) {
    if (!places.empty())
      at = places[tier].begin;
    for (IndexPage& page : table.pages) {
      page.begins[tier] = at;
      at += page.sizes[tier];
      if (at > kMaxBytes)
        return wrong("an impossible size");
    }
    if (!places.empty() && at != places[tier].begin + places[tier].bytes)
      return wrong("sizes that the table of grids does not have");
  }
  return table;
}

Result<PageContent> readIndexPage(const InputFile& file, const IndexPage& page,
                                  const BlockGrid& grid, const BlockDecoder& decoder) {
  const std::size_t tiers = decoder.tierLevels().size();
  const auto wrong = [&](std::string_view what) {
    return fail(ErrorCode::kInvalidData, "{}: the page of its index at byte {} gives {}",
                file.path().string(), page.offset, what);
  };
  // Zeros pack well, but not without end.
  const std::size_t means =
      decoder.hasMeans() ? static_cast<std::size_t>(grid.channels()) : std::size_t{0};
  const std::uint64_t limit =
      page.blocks * (kNumberBytes + kSizeBytes * tiers + kNumberBytes * means);
  constexpr std::uint64_t kMaxPacked = 4096;
  if (page.blocks / kMaxPacked > page.bytes)
    return wrong("an impossible number of blocks");
  VOLUTE_ASSIGN(const auto content, readPage(file, page.offset, page.bytes, page.crc, limit));
  ByteReader in(content);
  PageContent all;
  if (page.blocks > 1 + in.remaining())
    return wrong("fewer blocks than the list of pages");
  all.blocks.reserve(static_cast<std::size_t>(page.blocks));
  std::uint64_t block = page.firstBlock;
  for (std::uint64_t i = 0; i < page.blocks; ++i) {
    const std::uint64_t step = i > 0 ? in.varint() : 0;
    if (!in.ok() || step >= grid.count() - block || (i > 0 && step == 0))
      return wrong("a block that cannot be");
    all.blocks.push_back(block += step);
  }
  all.segments.reserve(all.blocks.size() * tiers);
  for (std::size_t tier = 0; tier < tiers; ++tier) {
    std::uint64_t offset = page.begins[tier];
    for (const std::uint64_t number : all.blocks) {
      const std::uint64_t size = in.varint();
      const BlockShape shape{grid.extents(static_cast<std::size_t>(number)), grid.channels()};
      if (!in.ok() || (size > 0 && size <= kChecksumBytes) ||
          size > decoder.maxSegmentBytes(shape, tier) + kChecksumBytes)
        return wrong(fmt::format("block {} an impossible size in tier {}", number, tier));
      all.segments.push_back({offset, static_cast<std::uint32_t>(size), 0});
      offset += size;
    }
    if (offset != page.begins[tier] + page.sizes[tier])
      return wrong(fmt::format("sizes in tier {} that do not add up", tier));
  }
  constexpr std::int64_t kGreatestMean = std::int64_t{1} << 52;
  all.means.resize(all.blocks.size() * means);
  for (std::size_t c = 0; c < means; ++c) {
    std::int64_t last = 0;
    for (std::size_t i = 0; i < all.blocks.size(); ++i) {
      const std::int64_t step = in.zigzag();
      if (!in.ok() || step < -2 * kGreatestMean || step > 2 * kGreatestMean ||
          (last += step) < -kGreatestMean || last > kGreatestMean)
        return wrong(fmt::format("block {} an impossible mean", all.blocks[i]));
      all.means[i * means + c] = last;
    }
  }
  if (in.remaining() != 0)
    return wrong("more than its blocks");
  return all;
}

Result<FrameTiles> readTilePage(const InputFile& file, const TilePage& page, int endRow,
                                const BlockGrid& grid, std::uint64_t budget) {
  VOLUTE_ASSIGN(const auto content, readPage(file, page.offset, page.bytes, page.crc, budget));
  const int first = page.firstRow * grid.frames();
  const int end = grid.endOfRow(endRow - 1);
  ByteReader in(content);
  FrameTiles tiles;
  const auto blame = [&](const Error& error) {
    return fail(error.code, error.hints, "{}: the page of tiles at byte {} is malformed: {}",
                file.path().string(), page.offset, error.message);
  };
  for (int frame = first; frame < end; ++frame) {
    auto one = readTiles(in, static_cast<std::size_t>(grid.channels()), budget);
    if (!one)
      return blame(one.error());
    tiles.push_back(std::move(*one));
  }
  if (in.remaining() != 0)
    return blame({ErrorCode::kInvalidData, "it goes on after its last frame"});
  return tiles;
}

void appendChecksum(std::vector<std::byte>& values) {
  ByteWriter crc;
  crc.u32(crc32(values));
  const auto bytes = crc.view();
  values.insert(values.end(), bytes.begin(), bytes.end());
}

bool isIntact(std::span<const std::byte> segment) {
  if (segment.size() <= kChecksumBytes)
    return false;
  ByteReader crc(segment.last(kChecksumBytes));
  return checksumMatches(segment.first(segment.size() - kChecksumBytes), crc.u32());
}

}  // namespace volute
