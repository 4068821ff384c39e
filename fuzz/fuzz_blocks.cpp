// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// What lies below the checksums of a .volute file: the list of its pages, the pages, parameters
// with their table of contexts, and blocks of codecs 2 and 3 with their topology. The first byte
// says which.
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <string>
#include <vector>

#include "volute/base/checksum.hpp"
#include "volute/base/input_file.hpp"
#include "volute/codec/block_codec.hpp"
#include "volute/codec/block_index.hpp"
#include "volute/codec/byte_io.hpp"
#include "volute/codec/wavelet_codec.hpp"

namespace {

using namespace volute;

VolumeInfo volume(int frames, int side, int channels) {
  VolumeInfo info;
  info.frames = frames;
  info.x = info.y = info.z = side;
  info.channels = channels;
  return info;
}

/// A file whose content is `bytes`.
InputFile fileOf(std::span<const std::byte> bytes) {
  static const int file = ::memfd_create("fuzz.page", 0);
  if (::ftruncate(file, 0) != 0 ||
      ::pwrite(file, bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
    std::abort();
  auto opened = InputFile::open("/proc/self/fd/" + std::to_string(file));
  if (!opened)
    std::abort();
  return std::move(*opened);
}

void require(bool holds) {
  if (!holds)
    std::abort();
}

void readTable(std::span<const std::byte> bytes) {
  const BlockGrid grid(volume(1000, 100000, 1));
  const auto table = readPageTable(bytes, grid, 3, 1000, {});
  if (!table)
    return;
  std::uint64_t next = 0;
  for (const IndexPage& page : table->pages) {
    require(page.firstBlock >= next && page.blocks > 0);
    next = page.firstBlock + page.blocks;
    require(next <= grid.count());
  }
}

void readBlocksPage(ByteReader& in) {
  IndexPage page;
  page.firstBlock = in.u8();
  page.blocks = in.u16();
  for (std::size_t tier = 0; tier < 3; ++tier) page.sizes[tier] = in.u32();
  const auto bytes = in.bytes(in.remaining());
  page.bytes = static_cast<std::uint32_t>(bytes.size());
  page.crc = crc32(bytes);
  const BlockGrid grid(volume(40, 1000, 1));
  WaveletParameters parameters;
  parameters.sparse = true;
  const auto decoder = openWaveletDecoder(kSparseCodec, writeParameters(parameters, 1), {});
  require(decoder.has_value());
  const auto content = readIndexPage(fileOf(bytes), page, grid, **decoder);
  if (!content)
    return;
  require(content->blocks.size() == page.blocks && content->segments.size() == 3 * page.blocks);
  require(std::ranges::is_sorted(content->blocks) && content->blocks.back() < grid.count());
}

void readTilesPage(ByteReader& in) {
  TilePage page;
  page.firstRow = in.u8() % 3;
  const int channels = in.u8() % 2 == 0 ? 1 : 3;
  const auto bytes = in.bytes(in.remaining());
  page.bytes = static_cast<std::uint32_t>(bytes.size());
  page.crc = crc32(bytes);
  const auto tiles =
      readTilePage(fileOf(bytes), page, 3, BlockGrid(volume(40, 1000, channels)), 1 << 20);
  require(!tiles || tiles->size() == static_cast<std::size_t>(40 - 16 * page.firstRow));
}

// Finite values within the range, or an error; the same twice, and of one frame as of all.
void readBlock(std::uint32_t codec, ByteReader& in) {
  const unsigned flags = in.u8();
  BlockShape shape;
  shape.channels = (flags & 1) != 0 ? 3 : 1;
  for (int& extent : shape.extents) extent = 1 + in.u8() % 16;
  const auto parameters = in.bytes(in.u16());
  std::vector<std::vector<std::byte>> tiers;
  for (int tier = 0; tier < 3; ++tier) {
    const auto bytes = in.bytes(tier < 2 ? in.u16() : in.remaining());
    tiers.emplace_back(bytes.begin(), bytes.end());
  }
  if (!in.ok())
    return;
  constexpr StreamInfo kStream{1, -1, 2};
  StreamInfo stream = kStream;
  stream.channels = shape.channels;
  const auto decoder = openWaveletDecoder(codec, parameters, stream);
  if (!decoder)
    return;
  const int levels = (flags & 2) != 0 ? 1 + static_cast<int>(flags >> 2) % 5 : 99;
  std::vector<float> values(shape.values()), again(values.size());
  BlockStates states;
  const bool good = (*decoder)->decode(tiers, levels, shape, values, &states).has_value();
  require(good == (*decoder)->decode(tiers, levels, shape, again).has_value());
  (void)(*decoder)->describe(tiers, shape);
  if (!good)
    return;
  require(states.size() == shape.voxels());
  require(std::ranges::all_of(values, [](float value) { return std::isfinite(value); }));
  require(std::ranges::equal(values, again));
  const int frame = static_cast<int>(flags >> 4) % shape.extents[0];
  require((*decoder)->decode(tiers, levels, shape, again, nullptr, {frame, frame + 1}).has_value());
  const std::size_t size = values.size() / static_cast<std::size_t>(shape.extents[0]);
  const std::size_t begin = static_cast<std::size_t>(frame) * size;
  require(std::ranges::equal(std::span(values).subspan(begin, size),
                             std::span(again).subspan(begin, size)));
  const std::array<float, 3> means{0.25f, -0.5f, 1.5f};
  require((*decoder)
              ->decode(tiers, levels, shape, again, nullptr, {},
                       std::span(means).first(static_cast<std::size_t>(shape.channels)))
              .has_value());
  require(std::ranges::all_of(again, [](float value) { return std::isfinite(value); }));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0)
    return 0;
  const auto bytes = std::as_bytes(std::span(data, size)).subspan(1);
  ByteReader in(bytes);
  switch (data[0] % 5) {
    case 0:
      readTable(bytes);
      break;
    case 1:
      readBlocksPage(in);
      break;
    case 2:
      readTilesPage(in);
      break;
    case 3:
      readBlock(kWaveletCodec, in);
      break;
    default:
      readBlock(kSparseCodec, in);
  }
  return 0;
}
