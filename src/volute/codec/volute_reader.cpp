// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/volute_reader.hpp"

#include <algorithm>
#include <cstring>
#include <mutex>
#include <tuple>
#include <type_traits>
#include <utility>

#include "volute/codec/container.hpp"
#include "volute/codec/packing.hpp"
#include "volute/codec/parallel_try.hpp"
#include "volute/grid/bricks.hpp"

namespace volute {

struct VoluteReader::Impl {
  using Index4 = BlockGrid::Index4;

  Impl(InputFile openFile, const Options& chosen, FileHead readHead)
      : file(std::move(openFile)),
        options(chosen),
        head(std::move(readHead)),
        grid(head.blockGrid()) {
    indexRequests = static_cast<std::uint64_t>(head.requests);
    indexBytes = head.bytesRead;
    if (!paged()) {
      // Codec 2 has its index in the head: one page, which is there.
      head.pages.pages = {IndexPage{.blocks = head.blocks.size()}};
      pages = {
          std::make_shared<const PageContent>(std::move(head.blocks), std::move(head.segments))};
    }
    pages.resize(head.pages.pages.size());
    tilePages.resize(head.pages.tiles.size());
    added = readsDifferences() ? 0 : head.header.offset;
    for (VoluteGrid& one : head.grids) showNumbers(one.header);
    showNumbers(head.header);
  }

  bool readsDifferences() const {
    const auto& description = head.own().description;
    const bool floats = description && description->isOfFloats();
    return options.differences == Offsets::kAll ||
           (options.differences == Offsets::kOfRounded && !floats);
  }

  /// The original's, not its differences'.
  static void showNumbers(VoluteHeader& header) {
    header.valueMin += header.offset, header.valueMax += header.offset;
    if (header.support)
      header.support->low += header.offset, header.support->high += header.offset;
  }

  InputFile file;
  Options options;
  FileHead head;
  BlockGrid grid;
  double added = 0;  // to what the file has
  mutable std::atomic<std::uint64_t> bytesRead{0};
  mutable std::atomic<std::uint64_t> blocksDecoded{0};
  mutable std::atomic<std::uint64_t> indexRequests{0}, indexBytes{0};
  // Those that were read, as many as memory allows.
  mutable std::mutex mutex;
  mutable std::vector<std::shared_ptr<const PageContent>> pages;
  mutable std::vector<std::shared_ptr<const FrameTiles>> tilePages;
  mutable std::uint64_t pageMemory = 0;

  std::size_t tiers() const { return head.decoder->tierLevels().size(); }

  /// Where a block is; one that is not in the file has no bytes.
  struct Place {
    bool occupied = false;
    std::array<SegmentEntry, kMaxBlockTiers> segments{};
    std::array<std::int64_t, 3> means{};
  };

  Result<std::shared_ptr<const PageContent>> page(std::size_t number) const;
  Result<std::shared_ptr<const FrameTiles>> tilePage(std::size_t number) const;

  /// A damaged page has nothing where only what is intact is asked for.
  template <class Content>
  Result<std::shared_ptr<const Content>> intact(Result<std::shared_ptr<const Content>> page) const {
    return page || !options.partial ? std::move(page) : std::make_shared<const Content>();
  }

  Result<Place> placeOf(std::size_t block) const;

  /// Makes room for more pages, where what is there takes too much.
  void makeRoom(std::uint64_t bytes) const {
    pageMemory += bytes;
    if (pageMemory <= options.maxMemory / 8)
      return;
    pageMemory = bytes;
    if (paged())
      std::ranges::fill(pages, nullptr);
    std::ranges::fill(tilePages, nullptr);
  }

  /// Calls visit(tile) for the tiles of a frame.
  template <class Visit>
  Status visitTiles(int frame, const Visit& visit) const {
    const auto& all = head.pages.tiles;
    const auto next = std::ranges::upper_bound(all, grid.rowOf(frame), {}, &TilePage::firstRow);
    if (next == all.begin())
      return {};
    const auto number = static_cast<std::size_t>(next - all.begin() - 1);
    VOLUTE_ASSIGN(const auto tiles, intact(tilePage(number)));
    const int first = all[number].firstRow * grid.frames();
    if (tiles->empty())
      return {};
    for (const Bricks::Tile& tile : (*tiles)[static_cast<std::size_t>(frame - first)]) visit(tile);
    return {};
  }

  /// What is nowhere else said. Without topology the cache's own background, where there is one.
  std::array<float, 3> backgroundOf(int row) const {
    const auto& description = head.own().description;
    if (paged() || !description) {
      auto own = head.decoderOf(row).background();
      for (float& value : own) value = static_cast<float>(added + static_cast<double>(value));
      return own;
    }
    std::array<float, 3> background{};
    for (std::size_t c = 0; c < 3; ++c)
      background[c] = static_cast<float>(description->background[c]);
    return background;
  }

  bool paged() const { return head.header.codec == static_cast<int>(kSparseCodec); }

  /// The blocks of the file in row `row`.
  Result<std::vector<std::uint64_t>> blocksOf(int row) const {
    const std::uint64_t first = static_cast<std::uint64_t>(row) * grid.rowCount();
    return blocksBetween(first, first + grid.rowCount());
  }

  Result<std::vector<std::uint64_t>> blocksBetween(std::uint64_t first, std::uint64_t end) const;
  Status putTiles(std::size_t block, std::span<float> values) const;
  Status readBlockBricks(std::size_t block, int first, int end, std::span<Bricks> bricks) const;

  tl::unexpected<Error> blame(std::size_t block, std::uint64_t offset, ErrorCode code,
                              std::string_view what) const;
  Status readSegment(std::size_t block, const SegmentEntry& at,
                     std::vector<std::byte>& bytes) const;
  Result<std::vector<std::vector<std::byte>>> readTiers(std::size_t block, const Place& place,
                                                        int levels) const;
  Status decodeBlock(std::size_t block, std::span<float> values, int levels,
                     BlockStates* states = nullptr, FrameSpan wanted = {}) const;
  Status decodeDifferences(std::size_t block, std::span<float> values, int levels,
                           BlockStates* states, FrameSpan wanted) const;
  Status checkBox(const Index4& begin, const Index4& end, std::size_t values) const;
  Status readPart(std::size_t block, const Index4& begin, const Index4& end,
                  std::span<float> values, int levels) const;
  Status readBox(const Index4& begin, const Index4& end, std::span<float> values, int levels) const;
  Status readKeptPart(std::size_t part, std::vector<std::byte>& packed) const;
};

// "fire.volute: block 7 (frames 16-31), byte 9000: its checksum is wrong"
tl::unexpected<Error> VoluteReader::Impl::blame(std::size_t block, std::uint64_t offset,
                                                ErrorCode code, std::string_view what) const {
  const auto first = static_cast<std::size_t>(grid.origin(block)[0]);
  const auto last = first + static_cast<std::size_t>(grid.extents(block)[0]) - 1;
  return fail(code, Hint::set("partial").so("shows what is intact"),
              "{}: block {} (frames {}-{}), byte {}: {}", file.path().string(), block,
              head.info.frameText(first), head.info.frameText(last), offset, what);
}

Result<std::shared_ptr<const PageContent>> VoluteReader::Impl::page(std::size_t number) const {
  const std::lock_guard lock(mutex);
  if (pages[number])
    return pages[number];
  const IndexPage& from = head.pages.pages[number];
  ++indexRequests;
  indexBytes += from.bytes;
  auto content = readIndexPage(file, from, grid, *head.decoder);
  if (!content)
    return tl::unexpected(std::move(content).error());
  makeRoom(content->blocks.size() * (sizeof(std::uint64_t) + tiers() * sizeof(SegmentEntry)));
  return pages[number] = std::make_shared<const PageContent>(std::move(*content));
}

Result<std::shared_ptr<const FrameTiles>> VoluteReader::Impl::tilePage(std::size_t number) const {
  const std::lock_guard lock(mutex);
  if (tilePages[number])
    return tilePages[number];
  const auto& all = head.pages.tiles;
  const int end = number + 1 < all.size() ? all[number + 1].firstRow : grid.counts()[0];
  ++indexRequests;
  indexBytes += all[number].bytes;
  VOLUTE_ASSIGN(auto tiles, readTilePage(file, all[number], end, grid, options.maxMemory / 4));
  std::uint64_t count = 0;
  for (const auto& frame : tiles) count += frame.size();
  makeRoom(count * sizeof(Bricks::Tile));
  return tilePages[number] = std::make_shared<const FrameTiles>(std::move(tiles));
}

Result<VoluteReader::Impl::Place> VoluteReader::Impl::placeOf(std::size_t block) const {
  Place place;
  const auto& all = head.pages.pages;
  const auto next = std::ranges::upper_bound(all, block, {}, &IndexPage::firstBlock);
  if (next == all.begin())
    return place;
  VOLUTE_ASSIGN(const auto content, intact(page(static_cast<std::size_t>(next - all.begin() - 1))));
  const auto& blocks = content->blocks;
  const auto at = std::ranges::lower_bound(blocks, block);
  if (at == blocks.end() || *at != block)
    return place;
  place.occupied = true;
  const auto i = static_cast<std::size_t>(at - blocks.begin());
  for (std::size_t tier = 0; tier < tiers(); ++tier)
    place.segments[tier] = content->segments[tier * blocks.size() + i];
  const auto channels = static_cast<std::size_t>(grid.channels());
  for (std::size_t c = 0; c < channels && !content->means.empty(); ++c)
    place.means[c] = content->means[i * channels + c];
  return place;
}

Result<std::vector<std::uint64_t>> VoluteReader::Impl::blocksBetween(std::uint64_t first,
                                                                     std::uint64_t end) const {
  std::vector<std::uint64_t> blocks;
  const auto& all = head.pages.pages;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const bool after = i + 1 < all.size() && all[i + 1].firstBlock <= first;
    if (after || all[i].firstBlock >= end)
      continue;
    VOLUTE_ASSIGN(const auto content, intact(page(i)));
    const auto begin = std::ranges::lower_bound(content->blocks, first);
    blocks.insert(blocks.end(), begin, std::lower_bound(begin, content->blocks.end(), end));
  }
  return blocks;
}

Status VoluteReader::Impl::readSegment(std::size_t block, const SegmentEntry& at,
                                       std::vector<std::byte>& bytes) const {
  bytes.clear();
  if (at.size == 0)
    return {};
  if (at.offset + at.size > file.size()) {
    return blame(block, at.offset, ErrorCode::kTruncated,
                 fmt::format("the file ends at byte {} of {}", file.size(), head.fileBytes));
  }
  auto read = volute::readSegment(file, head, at);
  bytesRead += at.size;
  if (!read)
    return blame(block, at.offset, read.error().code, read.error().message);
  bytes = std::move(*read);
  bytes.resize(valuesOf(head, bytes).size());
  return {};
}

// The segments of the first `levels` levels; with `partial` only those before the first that is
// damaged.
Result<std::vector<std::vector<std::byte>>> VoluteReader::Impl::readTiers(std::size_t block,
                                                                          const Place& place,
                                                                          int levels) const {
  std::vector<std::vector<std::byte>> result;
  int firstLevel = 0;
  for (std::size_t tier = 0; tier < tiers() && firstLevel < levels; ++tier) {
    std::vector<std::byte> bytes;
    if (auto status = readSegment(block, place.segments[tier], bytes); !status) {
      if (options.partial)
        break;
      return tl::unexpected(std::move(status).error());
    }
    result.push_back(std::move(bytes));
    firstLevel += head.decoder->tierLevels()[tier];
  }
  return result;
}

// Tiles over what is decoded, which is background there.
Status VoluteReader::Impl::putTiles(std::size_t block, std::span<float> values) const {
  if (head.pages.tiles.empty())
    return {};
  const Index4 o = grid.origin(block), e = grid.extents(block);
  const IndexBox box{{o[3], o[2], o[1]}, {o[3] + e[3], o[2] + e[2], o[1] + e[1]}};
  const auto channels = static_cast<std::size_t>(grid.channels());
  for (int t = 0; t < e[0]; ++t) {
    VOLUTE_TRY(visitTiles(o[0] + t, [&](const Bricks::Tile& tile) {
      const IndexBox part = tile.box().intersection(box);
      if (part.empty())
        return;
      for (auto z = part.begin[2]; z < part.end[2]; ++z)
        for (auto y = part.begin[1]; y < part.end[1]; ++y) {
          const auto line =
              ((static_cast<std::size_t>(t) * e[1] + (z - o[1])) * e[2] + (y - o[2])) *
                  static_cast<std::size_t>(e[3]) +
              static_cast<std::size_t>(part.begin[0] - o[3]);
          float* to = values.data() + line * channels;
          for (auto x = part.begin[0]; x < part.end[0]; ++x)
            to = std::copy_n(tile.value.begin(), channels, to);
        }
    }));
  }
  return {};
}

Status VoluteReader::Impl::decodeBlock(std::size_t block, std::span<float> values, int levels,
                                       BlockStates* states, FrameSpan wanted) const {
  VOLUTE_TRY(decodeDifferences(block, values, levels, states, wanted));
  for (std::size_t i = 0; added != 0 && i < values.size(); ++i)
    values[i] = static_cast<float>(added + static_cast<double>(values[i]));
  return {};
}

Status VoluteReader::Impl::decodeDifferences(std::size_t block, std::span<float> values, int levels,
                                             BlockStates* states, FrameSpan wanted) const {
  // All levels of a small block are in its first tiers; the last one may have corrections.
  if (levels >= grid.levels(block))
    levels = 99;
  VOLUTE_ASSIGN(const Place place, placeOf(block));
  const BlockShape shape = shapeOf(grid, block);
  const BlockDecoder& decoder = head.decoderOf(grid.coordinate(block)[0]);
  const auto channels = static_cast<std::size_t>(shape.channels);
  std::array<float, 3> room{};
  std::span<const float> means;
  if (place.occupied && decoder.hasMeans()) {
    for (std::size_t c = 0; c < channels; ++c) room[c] = decoder.mean(place.means[c]);
    means = std::span(room).first(channels);
  }
  if (levels <= 1 && !means.empty()) {
    // With its tiles in it.
    fillFrames(values, shape, wanted, means);
    return {};
  }
  // Of a block with tiles, which are not among its voxels, the mean tells nothing.
  if (!head.pages.tiles.empty())
    means = {};
  VOLUTE_ASSIGN(auto bytes, readTiers(block, place, levels));
  if (place.occupied)
    ++blocksDecoded;
  Status status = decoder.decode(bytes, levels, shape, values, states, wanted, means);
  for (; !status && options.partial && !bytes.empty();
       status = decoder.decode(bytes, levels, shape, values, states, wanted, means)) {
    bytes.pop_back();
  }
  if (!status)
    return blame(block, place.segments[0].offset, status.error().code, status.error().message);
  return putTiles(block, values);
}

// What of a block is in the frames first <= frame < end: bricks of 8^3 from its origin on.
Status VoluteReader::Impl::readBlockBricks(std::size_t block, int first, int end,
                                           std::span<Bricks> bricks) const {
  const Index4 o = grid.origin(block), e = grid.extents(block);
  const auto channels = static_cast<std::size_t>(grid.channels());
  std::vector<float> values(grid.values(block));
  BlockStates states;
  const FrameSpan wanted{std::max(0, first - o[0]), std::min(e[0], end - o[0])};
  VOLUTE_TRY(decodeBlock(block, values, 99, &states, wanted));
  const int row = grid.coordinate(block)[0];
  const std::array<float, 3> background = backgroundOf(row);
  const bool topology = head.decoderOf(row).hasTopology();
  constexpr int kSide = Bricks::kSide;
  for (int t = wanted.first; t < wanted.end; ++t) {
    Bricks& frame = bricks[static_cast<std::size_t>(o[0] + t - first)];
    for (int z0 = 0; z0 < e[1]; z0 += kSide)
      for (int y0 = 0; y0 < e[2]; y0 += kSide)
        for (int x0 = 0; x0 < e[3]; x0 += kSide) {
          Bricks::Leaf leaf{{o[3] + x0, o[2] + y0, o[1] + z0}};
          std::uint64_t any = 0;
          const auto visit = [&](const auto& body) {
            for (int z = z0; z < std::min(z0 + kSide, e[1]); ++z)
              for (int y = y0; y < std::min(y0 + kSide, e[2]); ++y) {
                const std::size_t line = ((static_cast<std::size_t>(t) * e[1] + z) * e[2] + y) *
                                         static_cast<std::size_t>(e[3]);
                for (int x = x0; x < std::min(x0 + kSide, e[3]); ++x)
                  body(line + static_cast<std::size_t>(x), static_cast<std::size_t>(z - z0),
                       kSide * (y - y0) + x - x0);
              }
          };
          visit([&](std::size_t at, std::size_t z, int bit) {
            bool valued = states[at] != VoxelState::kEmpty,
                 active = states[at] == VoxelState::kActive;
            if (!topology) {
              // Without topology: what is not the background.
              const float* value = &values[at * channels];
              valued = active = !std::equal(value, value + channels, background.begin());
            }
            leaf.active[z] |= static_cast<std::uint64_t>(active) << bit;
            leaf.valued[z] |= static_cast<std::uint64_t>(valued) << bit;
            any |= leaf.valued[z];
          });
          if (any == 0)
            continue;
          const std::span<float> to = frame.addLeaf(leaf);
          visit([&](std::size_t at, std::size_t z, int bit) {
            if ((leaf.valued[z] >> bit & 1) == 0)
              return;
            for (std::size_t c = 0; c < channels; ++c)
              to[c * Bricks::kVoxels + 64 * z + static_cast<std::size_t>(bit)] =
                  values[at * channels + c];
          });
        }
  }
  return {};
}

Status VoluteReader::Impl::checkBox(const Index4& begin, const Index4& end,
                                    std::size_t values) const {
  const Index4& volume = grid.volumeExtents();
  bool fits = true;
  std::size_t wanted = static_cast<std::size_t>(grid.channels());
  for (std::size_t axis = 0; fits && axis < 4; ++axis) {
    fits = begin[axis] >= 0 && begin[axis] < end[axis] && end[axis] <= volume[axis];
    if (fits)
      wanted *= static_cast<std::size_t>(end[axis] - begin[axis]);
  }
  if (fits && wanted == values)
    return {};
  return fail(ErrorCode::kInvalidArgument,
              "{}: frames {}:{}, z {}:{}, y {}:{}, x {}:{} do not lie inside the {} x {} x {} x {} "
              "of the file (t, z, y, "
              "x), or do not fill the room for {} values",
              file.path().string(), begin[0], end[0], begin[1], end[1], begin[2], end[2], begin[3],
              end[3], volume[0], volume[1], volume[2], volume[3], values);
}

// Decodes a block and copies what of it lies in [begin, end) to its place there.
Status VoluteReader::Impl::readPart(std::size_t block, const Index4& begin, const Index4& end,
                                    std::span<float> values, int levels) const {
  const Index4 origin = grid.origin(block);
  const Index4 extents = grid.extents(block);
  const auto channels = static_cast<std::size_t>(grid.channels());
  thread_local std::vector<float> decoded;  // as costly to get as to use
  decoded.resize(grid.values(block));
  Index4 low{}, high{};
  for (std::size_t axis = 0; axis < 4; ++axis) {
    low[axis] = std::max(begin[axis], origin[axis]);
    high[axis] = std::min(end[axis], origin[axis] + extents[axis]);
  }
  VOLUTE_TRY(
      decodeBlock(block, decoded, levels, nullptr, {low[0] - origin[0], high[0] - origin[0]}));
  // Where (t, z, y, low x) is in an array that starts at `from` and ends at `to`.
  const auto place = [channels, x = low[3]](int t, int z, int y, const Index4& from,
                                            const Index4& to) {
    std::size_t at = static_cast<std::size_t>(t - from[0]);
    at = at * (to[1] - from[1]) + (z - from[1]);
    at = at * (to[2] - from[2]) + (y - from[2]);
    return (at * (to[3] - from[3]) + (x - from[3])) * channels;
  };
  Index4 blockEnd{};
  for (std::size_t axis = 0; axis < 4; ++axis) blockEnd[axis] = origin[axis] + extents[axis];
  const std::size_t line = static_cast<std::size_t>(high[3] - low[3]) * channels;
  const auto copyLines = [&](auto size) {
    for (int t = low[0]; t < high[0]; ++t)
      for (int z = low[1]; z < high[1]; ++z)
        for (int y = low[2]; y < high[2]; ++y)
          std::memcpy(values.data() + place(t, z, y, begin, end),
                      decoded.data() + place(t, z, y, origin, blockEnd), size * sizeof(float));
  };
  // A size that is known needs no call for each line.
  if (line == BlockGrid::kSide)
    copyLines(std::integral_constant<std::size_t, BlockGrid::kSide>());
  else
    copyLines(line);
  return {};
}

Status VoluteReader::Impl::readBox(const Index4& begin, const Index4& end, std::span<float> values,
                                   int levels) const {
  VOLUTE_TRY(checkBox(begin, end, values.size()));
  Index4 first{}, count{};
  std::size_t touched = 1;
  for (std::size_t axis = 0; axis < 4; ++axis) {
    first[axis] = begin[axis] / grid.sides()[axis];
    count[axis] = (end[axis] - 1) / grid.sides()[axis] - first[axis] + 1;
    touched *= static_cast<std::size_t>(count[axis]);
  }
  return parallelTry(touched, [&](std::size_t i) {
    Index4 at{};
    for (std::size_t axis = 4; axis-- > 0; i /= static_cast<std::size_t>(count[axis])) {
      at[axis] = first[axis] + static_cast<int>(i % static_cast<std::size_t>(count[axis]));
    }
    return readPart(grid.blockAt(at), begin, end, values, levels);
  });
}

Status VoluteReader::Impl::readKeptPart(std::size_t part, std::vector<std::byte>& packed) const {
  const SegmentEntry& at = head.kept.parts[part];
  if (at.offset + at.size > file.size())
    return fail(ErrorCode::kTruncated, "{}: ends at byte {} of {}, before the grids that it keeps",
                file.path().string(), file.size(), head.fileBytes);
  packed.resize(at.size);
  VOLUTE_TRY(file.read(at.offset, packed));
  if (!checksumMatches(packed, at.crc))
    return fail(ErrorCode::kInvalidData, "{}: a kept grid is damaged at byte {}",
                file.path().string(), at.offset);
  return {};
}

VoluteReader::VoluteReader(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

VoluteReader::VoluteReader(VoluteReader&&) noexcept = default;
VoluteReader& VoluteReader::operator=(VoluteReader&&) noexcept = default;
VoluteReader::~VoluteReader() = default;

Result<VoluteReader> VoluteReader::open(const std::filesystem::path& path, const Options& options) {
  VOLUTE_ASSIGN(InputFile file, InputFile::open(path));
  return open(std::move(file), options);
}

Result<VoluteReader> VoluteReader::open(InputFile file, const Options& options) {
  VOLUTE_ASSIGN(FileHead head, readHead(file, options.maxMemory, options.grid));
  if (file.size() < head.fileBytes && !options.partial) {
    return fail(ErrorCode::kTruncated, Hint::set("partial").so("shows what is intact"),
                "{}: is truncated: it ends at byte {} of {}", file.path().string(), file.size(),
                head.fileBytes);
  }
  return VoluteReader(std::make_unique<Impl>(std::move(file), options, std::move(head)));
}

const VolumeInfo& VoluteReader::info() const {
  return impl_->head.info;
}

const VoluteHeader& VoluteReader::header() const {
  return impl_->head.header;
}

double VoluteReader::offset() const {
  return impl_->readsDifferences() ? header().offset : 0;
}

const BlockGrid& VoluteReader::blocks() const {
  return impl_->grid;
}

const std::vector<VoluteGrid>& VoluteReader::grids() const {
  return impl_->head.grids;
}

const VoluteGrid& VoluteReader::grid() const {
  return impl_->head.own();
}

const FrameMetadata& VoluteReader::fileMetadata() const {
  return impl_->head.fileMetadata;
}

const KeptTable& VoluteReader::kept() const {
  return impl_->head.kept;
}

std::unique_ptr<KeptBytes> VoluteReader::keptBytes(std::size_t grid, int frame) const {
  class Piece final : public KeptBytes {
   public:
    Piece(const Impl& impl, int piece)
        : impl_(impl), left_(impl.head.kept.pieceBytes[static_cast<std::size_t>(piece)]) {
      std::tie(part_, end_) = impl.head.kept.partsOf(piece);
      size_ = left_;
    }

    std::uint64_t size() const override { return size_; }

    Result<std::span<const std::byte>> next() override {
      if (part_ == end_)
        return std::span<const std::byte>();
      const std::uint64_t expected = std::min<std::uint64_t>(left_, kPart);
      std::vector<std::byte> packed;
      VOLUTE_TRY(impl_.readKeptPart(part_, packed));
      auto content = unpack(packed, expected);
      if (!content || content->size() != expected) {
        return fail(ErrorCode::kInvalidData, "{}: a kept grid {}", impl_.file.path().string(),
                    content ? "is shorter than stated" : content.error().message);
      }
      content_ = *std::move(content);
      left_ -= expected;
      ++part_;
      return std::span<const std::byte>(content_);
    }

   private:
    const Impl& impl_;
    std::size_t part_ = 0, end_ = 0;
    std::uint64_t left_, size_ = 0;
    std::vector<std::byte> content_;
  };

  const int piece = kept().grids[grid].pieces[static_cast<std::size_t>(frame)];
  return piece < 0 ? nullptr : std::make_unique<Piece>(*impl_, piece);
}

void VoluteReader::verifyKept(Integrity& integrity) const {
  std::vector<std::byte> packed;
  for (std::size_t part = 0; part < kept().parts.size(); ++part) {
    ++integrity.segments;
    const Status status = impl_->readKeptPart(part, packed);
    if (status)
      ++integrity.intactSegments;
    else if (integrity.firstFault.empty())
      integrity.firstFault = status.error().message;
  }
}

std::uint64_t VoluteReader::maxMemory() const {
  return impl_->options.maxMemory;
}

std::uint64_t VoluteReader::bytesRead() const {
  return impl_->bytesRead;
}

std::uint64_t VoluteReader::blocksDecoded() const {
  return impl_->blocksDecoded;
}

Status VoluteReader::readBricks(int first, int end, std::span<Bricks> bricks) const {
  const Impl& impl = *impl_;
  const int row = impl.grid.rowOf(std::max(first, 0));
  if (first < 0 || first >= end || end > impl.grid.endOfRow(row) ||
      bricks.size() != static_cast<std::size_t>(end - first)) {
    return fail(ErrorCode::kInvalidArgument,
                "{}: frames {}:{} were asked of row {}, with room for {}",
                impl.file.path().string(), first, end, row, bricks.size());
  }
  VOLUTE_ASSIGN(const std::vector<std::uint64_t> blocks, impl.blocksOf(row));
  for (Bricks& frame : bricks) frame = Bricks(impl.grid.channels(), impl.backgroundOf(row));
  // Leaves of neighbouring blocks go behind each other, some blocks to a task.
  constexpr std::size_t kBlocksATask = 16;
  const std::size_t tasks = (blocks.size() + kBlocksATask - 1) / kBlocksATask;
  std::vector<std::vector<Bricks>> parts(tasks, std::vector<Bricks>(bricks.begin(), bricks.end()));
  VOLUTE_TRY(parallelTry(tasks, [&](std::size_t task) -> Status {
    for (std::size_t i = task * kBlocksATask;
         i < std::min(blocks.size(), (task + 1) * kBlocksATask); ++i)
      VOLUTE_TRY(
          impl.readBlockBricks(static_cast<std::size_t>(blocks[i]), first, end, parts[task]));
    return {};
  }));
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    for (auto& part : parts) {
      bricks[i].append(part[i]);
      part[i] = Bricks();
    }
    VOLUTE_TRY(impl.visitTiles(first + static_cast<int>(i), [&](Bricks::Tile tile) {
      for (float& value : tile.value) value = static_cast<float>(impl.added + value);
      bricks[i].addTile(tile);
    }));
    bricks[i].sort();
    bricks[i].fillUnderTiles();
  }
  return {};
}

std::uint64_t VoluteReader::brickBytes(int row) const {
  std::uint64_t bytes = 0;
  // Where they cannot be told, reading says why.
  for (const std::uint64_t block : impl_->blocksOf(row).value_or(std::vector<std::uint64_t>()))
    bytes += 5 * impl_->grid.values(static_cast<std::size_t>(block));
  return bytes;
}

std::array<float, 3> VoluteReader::background() const {
  return impl_->backgroundOf(0);
}

bool VoluteReader::hasTopology() const {
  return impl_->head.decoder->hasTopology();
}

Result<std::vector<std::uint64_t>> VoluteReader::occupied() const {
  return impl_->blocksBetween(0, impl_->grid.count());
}

std::uint64_t VoluteReader::occupiedCount() const {
  std::uint64_t count = 0;
  for (const IndexPage& page : impl_->head.pages.pages) count += page.blocks;
  return count;
}

std::uint64_t VoluteReader::indexRequests() const {
  return impl_->indexRequests;
}

std::uint64_t VoluteReader::indexBytes() const {
  return impl_->indexBytes;
}

Result<std::uint64_t> VoluteReader::storedBytes(std::size_t block) const {
  VOLUTE_ASSIGN(const auto place, impl_->placeOf(block));
  std::uint64_t bytes = 0;
  for (const SegmentEntry& segment : place.segments) bytes += segment.size;
  return bytes;
}

Result<std::string> VoluteReader::describeBlock(std::size_t block) const {
  VOLUTE_ASSIGN(const auto place, impl_->placeOf(block));
  VOLUTE_ASSIGN(const auto tiers, impl_->readTiers(block, place, 1));
  return impl_->head.decoderOf(impl_->grid.coordinate(block)[0])
      .describe(tiers, shapeOf(impl_->grid, block));
}

Integrity VoluteReader::verify() const {
  Progress quiet;
  return *verify(quiet);
}

Result<Integrity> VoluteReader::verify(Progress& progress) const {
  const Impl& impl = *impl_;
  Integrity integrity;
  integrity.expectedBytes = impl.head.fileBytes;
  integrity.presentBytes = impl.file.size();
  std::vector<std::byte> bytes;
  for (std::size_t number = 0; number < impl.tilePages.size(); ++number) {
    if (const auto tiles = impl.tilePage(number); !tiles && integrity.firstFault.empty())
      integrity.firstFault = tiles.error().message;
  }
  for (std::size_t tier = 0; tier < impl.tiers(); ++tier) {
    bool whole = true;
    progress.report("checking", static_cast<double>(tier), static_cast<double>(impl.tiers()));
    const auto fault = [&](const Error& error) {
      whole = false;
      if (integrity.firstFault.empty())
        integrity.firstFault = error.message;
    };
    for (std::size_t number = 0; number < impl.pages.size(); ++number) {
      const auto page = impl.page(number);
      if (!page) {
        fault(page.error());
        continue;
      }
      const auto& blocks = (*page)->blocks;
      for (std::size_t i = 0; i < blocks.size(); ++i) {
        const SegmentEntry& segment = (*page)->segments[tier * blocks.size() + i];
        if (segment.size == 0)
          continue;
        if (progress.cancelled())
          return fail(ErrorCode::kCancelled, "stopped");
        ++integrity.segments;
        const auto block = static_cast<std::size_t>(blocks[i]);
        if (const Status status = impl.readSegment(block, segment, bytes); status)
          ++integrity.intactSegments;
        else
          fault(status.error());
      }
    }
    if (whole && integrity.firstFault.empty())
      integrity.intactLevels += impl.head.decoder->tierLevels()[tier];
  }
  return integrity;
}

Status VoluteReader::readBlock(std::size_t block, std::span<float> values, int levels,
                               FrameSpan wanted) const {
  if (block >= impl_->grid.count() || values.size() != impl_->grid.values(block)) {
    return fail(ErrorCode::kInvalidArgument,
                "{}: block {} of {} was asked for with room for {} values",
                impl_->file.path().string(), block, impl_->grid.count(), values.size());
  }
  return impl_->decodeBlock(block, values, levels, nullptr, wanted);
}

Status VoluteReader::readBox(const BlockGrid::Index4& begin, const BlockGrid::Index4& end,
                             std::span<float> values, int levels) const {
  return impl_->readBox(begin, end, values, levels);
}

Status VoluteReader::readRegion(int frame, const std::array<int, 3>& begin,
                                const std::array<int, 3>& end, std::span<float> values,
                                int levels) const {
  return impl_->readBox({frame, begin[0], begin[1], begin[2]}, {frame + 1, end[0], end[1], end[2]},
                        values, levels);
}

Status VoluteReader::readRow(int row, std::span<float> values, int levels) const {
  const BlockGrid::Index4& volume = impl_->grid.volumeExtents();
  const int one = std::clamp(row, 0, impl_->grid.counts()[0] - 1);
  return impl_->readBox({one * impl_->grid.frames(), 0, 0, 0},
                        {impl_->grid.endOfRow(one), volume[1], volume[2], volume[3]}, values,
                        levels);
}

}  // namespace volute
