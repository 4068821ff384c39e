// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <memory>
#include <span>
#include <vector>

#include "volute/base/input_file.hpp"
#include "volute/base/result.hpp"
#include "volute/codec/block_codec.hpp"
#include "volute/codec/block_grid.hpp"
#include "volute/codec/block_index.hpp"
#include "volute/codec/kept_grids.hpp"
#include "volute/codec/volute_reader.hpp"
#include "volute/grid/bricks.hpp"
#include "volute/grid/volume_info.hpp"

namespace volute {

/// Rows of blocks that were compressed together, of a file that was joined from several.
struct FilePart {
  int firstRow = 0;                     ///< the rows up to that of the next part
  float valueMin = 0, valueMax = 0;     ///< that its values are clamped to
  std::vector<std::byte> parameters{};  ///< of the codec
  std::shared_ptr<const BlockDecoder> decoder{};
};

/// All that stands before the values of a .volute file: docs/format.md, sections 2 to 6.
struct FileHead {
  VolumeInfo info;
  VoluteHeader header;
  std::vector<std::byte> parameters;  ///< of the codec; of several parts those of the first
  std::shared_ptr<const BlockDecoder> decoder;
  /// Of a file that was joined, in the order of rows; else empty.
  std::vector<FilePart> parts;
  /// Numbers of the blocks that are in the file, ascending: all of codec 2.
  std::vector<std::uint64_t> blocks;
  /// Tier by tier, block by block of `blocks`, as in the file.
  std::vector<SegmentEntry> segments;
  std::vector<std::int64_t> means{};  ///< as PageContent has them, of `blocks`
  FrameTiles tiles{};                 ///< empty, or of each frame
  PageTable pages{};                  ///< of codec 3: where the three above are
  std::optional<LookFigures> look{};
  std::uint64_t headBytes = 0;  ///< up to the pages, or the segments where there are none
  std::uint64_t fileBytes = 0;
  int requests = 0;             ///< in which the head was read
  std::uint64_t bytesRead = 0;  ///< in them
  /// All grids of the file; what is above is of own().
  std::vector<VoluteGrid> grids{};
  std::size_t grid = 0;  ///< none of them where no grid has values
  VoluteGrid standIn{};  ///< has the frames and times of such a file, and is empty
  FrameMetadata fileMetadata{};
  KeptTable kept{};  ///< of the file; of several heads that are written, the first one's

  const VoluteGrid& own() const { return grid < grids.size() ? grids[grid] : standIn; }

  BlockGrid blockGrid() const { return BlockGrid(info, decoder->blockFrames()); }

  /// Of the part that a row of blocks is of.
  const BlockDecoder& decoderOf(int row) const {
    const auto next = std::ranges::upper_bound(parts, row, {}, &FilePart::firstRow);
    return next == parts.begin() ? *decoder : *std::prev(next)->decoder;
  }

  /// Where a block is in `blocks`; blocks.size() where it is not.
  std::size_t placeOf(std::uint64_t block) const {
    if (block < blocks.size() && blocks[block] == block)
      return block;  // as all of them are there
    const auto at = std::ranges::lower_bound(blocks, block);
    return static_cast<std::size_t>((at != blocks.end() && *at == block ? at : blocks.end()) -
                                    blocks.begin());
  }

  /// @param place  of a block, placeOf()
  const SegmentEntry& segment(std::size_t tier, std::size_t place) const {
    return segments[tier * blocks.size() + place];
  }
};

BlockShape shapeOf(const BlockGrid& grid, std::size_t block);

/// The bytes up to the first segment; sets headBytes, fileBytes and the segments' offsets from
/// their sizes.
std::vector<std::byte> writeHead(FileHead& head);

/// The same of a file with a table of grids.
/// @param grids  their names, descriptions and emptiness; `heads` are those of the grids that are
/// not empty, in the same order, which have the same frames; where all are empty, the stand-in's.
std::vector<std::byte> writeHead(std::span<const VoluteGrid> grids,
                                 const FrameMetadata& fileMetadata, std::span<FileHead> heads);

/// Reads and checks a head, for one of its grids (VoluteReader::Options::grid). Takes any bytes: it
/// allocates in proportion to what is there, and at most max(64 MiB, maxMemory). The file may end
/// before its last segment (the caller compares its size with fileBytes), but not after it.
/// Of codec 3 the pages are not read: blocks, segments and tiles are empty until readPages().
[[nodiscard]] Result<FileHead> readHead(const InputFile& file, std::uint64_t maxMemory,
                                        const std::string& grid = "");

/// Fills in what the pages hold, of all blocks; codec 2 has it without.
[[nodiscard]] Status readPages(const InputFile& file, std::uint64_t maxMemory, FileHead& head);

/// Both.
[[nodiscard]] Result<FileHead> readHeadAndPages(const InputFile& file, std::uint64_t maxMemory,
                                                const std::string& grid = "");

/// The bytes of a segment, which must be those that were written; an error is what is wrong, and
/// wants a subject.
[[nodiscard]] Result<std::vector<std::byte>> readSegment(const InputFile& file,
                                                         const FileHead& head,
                                                         const SegmentEntry& segment);

/// Of the bytes of a segment those that are of values.
std::span<const std::byte> valuesOf(const FileHead& head, std::span<const std::byte> segment);

/// True when `crc` is the checksum of `bytes`. A fuzzer's build takes any, to reach what lies
/// behind.
bool checksumMatches(std::span<const std::byte> bytes, std::uint32_t crc);

}  // namespace volute
