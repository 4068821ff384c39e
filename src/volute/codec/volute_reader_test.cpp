// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <limits>

#include "volute/base/checksum.hpp"
#include "volute/base/parallel.hpp"
#include "volute/codec/byte_io.hpp"
#include "volute/codec/codec_testing.hpp"
#include "volute/codec/container.hpp"

namespace volute {
namespace {

using Kind = ErrorTarget::Kind;
using namespace testing;

constexpr VoluteReader::Options kPartial{true, std::uint64_t{64} << 20};
constexpr VoluteReader::Options kWhole{false, std::uint64_t{64} << 20};

// Two blocks along x, one of them of odd size, small enough to be broken in every bit.
Sequence smallSequence() {
  return plumes(3, 5, 6, 19);
}

struct SmallFile {
  SmallFile() : sequence(smallSequence()) {
    EXPECT_TRUE(compressTo(file.path(), sequence, {Kind::kRms, 5e-2}));
    bytes = readBytes(file.path());
    decoded = *readBack(file.path());
  }

  ScratchFile file;
  Sequence sequence, decoded;
  std::string bytes;
};

// A damaged file is refused; with `partial` it may also say that it is damaged, and then gives
// finite values.
::testing::AssertionResult damageIsFound(const std::filesystem::path& path) {
  if (readBack(path, kWhole))
    return ::testing::AssertionFailure() << "read as if whole";
  const auto reader = VoluteReader::open(path, kPartial);
  if (!reader)
    return ::testing::AssertionSuccess();
  if (reader->verify().complete())
    return ::testing::AssertionFailure() << "verified as if whole";
  const auto values = readBack(path, kPartial);
  if (!values)
    return ::testing::AssertionFailure() << "not readable in part: " << values.error().message;
  for (const float value : values->values) {
    if (!std::isfinite(value))
      return ::testing::AssertionFailure() << "a value that is not finite";
  }
  return ::testing::AssertionSuccess();
}

TEST(DamagedFile, EveryTruncationIsFound) {
  const ThreadLimit limit(1);
  const SmallFile small;
  ASSERT_LT(small.bytes.size(), 3000u);
  for (std::size_t size = small.bytes.size(); size-- > 0;) {
    std::filesystem::resize_file(small.file.path(), size);
    ASSERT_TRUE(damageIsFound(small.file.path()))
        << size << " of " << small.bytes.size() << " bytes";
  }
}

TEST(DamagedFile, EveryFlippedBitIsFound) {
  const ThreadLimit limit(1);
  const SmallFile small;
  std::fstream file(small.file.path(), std::ios::in | std::ios::out | std::ios::binary);
  const auto put = [&file](std::size_t at, int byte) {
    file.seekp(static_cast<std::streamoff>(at));
    file.put(static_cast<char>(byte));
    file.flush();
  };
  for (std::size_t at = 0; at < small.bytes.size(); ++at) {
    for (int bit = 0; bit < 8; ++bit) {
      put(at, small.bytes[at] ^ 1 << bit);
      ASSERT_TRUE(damageIsFound(small.file.path())) << "bit " << bit << " of byte " << at;
    }
    put(at, small.bytes[at]);
  }
  EXPECT_EQ(readBack(small.file.path())->values, small.decoded.values);
}

TEST(DamagedFile, TrailingBytesAreRefused) {
  SmallFile small;
  small.bytes.push_back(0);
  writeBytes(small.file.path(), small.bytes);
  for (const auto& options : {kWhole, kPartial}) {
    const auto reader = VoluteReader::open(small.file.path(), options);
    ASSERT_FALSE(reader);
    EXPECT_NE(reader.error().message.find("1 bytes after its end"), std::string::npos)
        << reader.error().message;
  }
}

TEST(DamagedFile, ATruncatedFilePlaysItsCoarseLevels) {
  const Sequence sequence = plumes(20, 32, 32, 32);
  const ScratchFile file;
  ASSERT_TRUE(compressTo(file.path(), sequence, {Kind::kRms, 3e-3}));
  const auto whole = VoluteReader::open(file.path());
  ASSERT_TRUE(whole);
  auto bytes = readBytes(file.path());
  bytes.resize(bytes.size() / 2);
  const ScratchFile cut;
  writeBytes(cut.path(), bytes);

  const auto refused = VoluteReader::open(cut.path());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kTruncated);
  EXPECT_EQ(refused.error().hints.at(0).setting, "partial");

  const auto reader = VoluteReader::open(cut.path(), kPartial);
  ASSERT_TRUE(reader) << reader.error().message;
  const Integrity integrity = reader->verify();
  EXPECT_FALSE(integrity.complete());
  EXPECT_GE(integrity.intactLevels, 3);
  EXPECT_LT(integrity.intactLevels, 5);
  EXPECT_EQ(integrity.presentBytes, bytes.size());
  for (std::size_t block = 0; block < reader->blocks().count(); ++block) {
    std::vector<float> part(reader->blocks().values(block)), coarse(part.size()), all(part.size());
    ASSERT_TRUE(reader->readBlock(block, part));
    ASSERT_TRUE(whole->readBlock(block, coarse, integrity.intactLevels));
    ASSERT_TRUE(whole->readBlock(block, all));
    EXPECT_TRUE(part == coarse || part == all) << block;
  }
}

TEST(DamagedFile, OnlyTheDamagedBlockIsRefusedAndItsFramesAreNamed) {
  const Sequence sequence = plumes(40, 16, 16, 16);
  const ScratchFile file;
  ASSERT_TRUE(compressTo(file.path(), sequence, {Kind::kRms, 3e-3}));
  auto bytes = readBytes(file.path());
  bytes.back() = static_cast<char>(bytes.back() ^ 1);
  writeBytes(file.path(), bytes);
  const auto reader = VoluteReader::open(file.path());
  ASSERT_TRUE(reader);
  std::vector<float> values(reader->blocks().values(0));
  EXPECT_TRUE(reader->readBlock(0, values));
  values.resize(reader->blocks().values(2));
  const auto refused = reader->readBlock(2, values);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("block 2 (frames 32-39), byte "), std::string::npos)
      << refused.error().message;
  EXPECT_EQ(refused.error().hints.at(0).setting, "partial");
}

// `bytes` with the prologue's checksum made right again.
std::string resealed(std::string bytes) {
  const std::uint32_t crc = crc32(std::as_bytes(std::span(bytes).first(32)));
  for (int i = 0; i < 4; ++i)
    bytes[32 + static_cast<std::size_t>(i)] = static_cast<char>(crc >> 8 * i);
  return bytes;
}

TEST(NewerFile, OtherVersionsAndCodecsAreUnsupportedNotDamaged) {
  const SmallFile small;
  const ScratchFile other;
  // Major version, codec; codec 1 was never released.
  for (const auto& [place, value] : {std::pair{8u, 9}, {12u, 9}, {12u, 1}}) {
    auto bytes = small.bytes;
    bytes[place] = static_cast<char>(value);
    writeBytes(other.path(), resealed(bytes));
    const auto reader = VoluteReader::open(other.path());
    ASSERT_FALSE(reader);
    EXPECT_EQ(reader.error().code, ErrorCode::kUnsupported) << reader.error().message;
  }
  auto minor = small.bytes;
  minor[10] = 3;
  writeBytes(other.path(), resealed(minor));
  EXPECT_TRUE(VoluteReader::open(other.path()));
}

// A file with a chunk of type `XTRA` between the prologue and INFO.
std::string withExtraChunk(const std::string& bytes, std::uint32_t flags) {
  ByteWriter frame;
  const std::string_view type = "XTRA", payload = "hello";
  frame.bytes(std::as_bytes(std::span(type)));
  frame.u32(flags);
  frame.u64(payload.size());
  ByteWriter chunk;
  chunk.bytes(frame.view());
  chunk.u32(crc32(frame.view()));
  chunk.bytes(std::as_bytes(std::span(payload)));
  chunk.u32(crc32(std::as_bytes(std::span(payload))));
  ByteReader sizes(std::as_bytes(std::span(bytes).subspan(16, 16)));
  const std::uint64_t headBytes = sizes.u64() + chunk.size();
  const std::uint64_t fileBytes = sizes.u64() + chunk.size();
  ByteWriter out;
  out.bytes(std::as_bytes(std::span(bytes).first(16)));
  out.u64(headBytes);
  out.u64(fileBytes);
  out.u32(0);
  out.bytes(chunk.view());
  out.bytes(std::as_bytes(std::span(bytes).subspan(36)));
  const auto* first = reinterpret_cast<const char*>(out.view().data());
  return resealed({first, first + out.size()});
}

TEST(NewerFile, UnknownChunksAreSkippedWhenTheySayThatTheyMayBe) {
  const SmallFile small;
  const ScratchFile other;
  writeBytes(other.path(), withExtraChunk(small.bytes, 1));
  const auto decoded = readBack(other.path());
  ASSERT_TRUE(decoded) << decoded.error().message;
  EXPECT_EQ(decoded->values, small.decoded.values);
  writeBytes(other.path(), withExtraChunk(small.bytes, 0));
  EXPECT_EQ(VoluteReader::open(other.path()).error().code, ErrorCode::kUnsupported);
}

TEST(VoluteReader, SaysWhatIsNoVoluteFile) {
  const ScratchFile file;
  for (const std::string text : {"", "hello", "a longer text that is not a volute file at all"}) {
    writeBytes(file.path(), text);
    const auto reader = VoluteReader::open(file.path());
    ASSERT_FALSE(reader);
    EXPECT_NE(reader.error().message.find("is not a .volute file"), std::string::npos);
  }
  EXPECT_EQ(VoluteReader::open(file.folder() / "missing").error().code, ErrorCode::kNotFound);
}

TEST(VoluteReader, ARegionTouchesItsBlocksAlone) {
  const Sequence sequence = plumes(19, 34, 30, 50);
  const ScratchFile file;
  ASSERT_TRUE(compressTo(file.path(), sequence, {Kind::kRms, 3e-3}));
  const auto all = readBack(file.path());
  const auto reader = VoluteReader::open(file.path());
  ASSERT_TRUE(reader);
  std::vector<float> one(4 * 5 * 6);
  ASSERT_TRUE(reader->readRegion(18, {17, 18, 33}, {21, 23, 39}, one));
  EXPECT_EQ(reader->blocksDecoded(), 1u);
  EXPECT_GT(reader->bytesRead(), 0u);
  EXPECT_EQ(reader->bytesRead(),
            reader->storedBytes(reader->blocks().blockAt({1, 1, 1, 2})).value());
  const auto expected = all->view().sub({18, 17, 18, 33, 0}, {1, 4, 5, 6, 1});
  for (int z = 0, i = 0; z < 4; ++z)
    for (int y = 0; y < 5; ++y)
      for (int x = 0; x < 6; ++x, ++i)
        ASSERT_EQ(one[static_cast<std::size_t>(i)], expected(0, z, y, x, 0));
}

RC_GTEST_PROP(VoluteReader, AnyRegionIsThatPartOfTheWhole, ()) {
  static const Sequence sequence = plumes(18, 20, 18, 35, 3);
  static const ScratchFile file;
  static const Sequence all = [] {
    EXPECT_TRUE(compressTo(file.path(), sequence, {Kind::kRms, 1e-2}));
    return *readBack(file.path());
  }();
  const auto reader = VoluteReader::open(file.path());
  RC_ASSERT(reader.has_value());
  std::array<int, 3> begin{}, end{};
  const std::array<int, 3> size{20, 18, 35};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    begin[axis] = *rc::gen::inRange(0, size[axis]);
    end[axis] = *rc::gen::inRange(begin[axis] + 1, size[axis] + 1);
  }
  const int frame = *rc::gen::inRange(0, 18);
  const std::array<std::ptrdiff_t, 5> extents{1, end[0] - begin[0], end[1] - begin[1],
                                              end[2] - begin[2], 3};
  std::vector<float> values(static_cast<std::size_t>(extents[1] * extents[2] * extents[3] * 3));
  RC_ASSERT(reader->readRegion(frame, begin, end, values).has_value());
  const auto expected = all.view().sub({frame, begin[0], begin[1], begin[2], 0}, extents);
  std::size_t i = 0;
  for (int z = 0; z < extents[1]; ++z)
    for (int y = 0; y < extents[2]; ++y)
      for (int x = 0; x < extents[3]; ++x)
        for (int c = 0; c < 3; ++c) RC_ASSERT(values[i++] == expected(0, z, y, x, c));
}

TEST(VoluteReader, RefusesRequestsThatDoNotFit) {
  const SmallFile small;
  const auto reader = VoluteReader::open(small.file.path());
  std::vector<float> values(8);
  EXPECT_FALSE(reader->readBlock(0, values));
  EXPECT_FALSE(reader->readBlock(99, values));
  EXPECT_FALSE(reader->readRegion(0, {0, 0, 0}, {2, 2, 3}, values));
  EXPECT_FALSE(reader->readRegion(3, {0, 0, 0}, {2, 2, 2}, values));
  EXPECT_FALSE(reader->readRegion(0, {-1, 0, 0}, {1, 2, 2}, values));
  EXPECT_TRUE(reader->readRegion(0, {0, 0, 0}, {2, 2, 2}, values));
}

TEST(VoluteReader, EachLevelBringsTheVolumeNearer) {
  const Sequence sequence = plumes(16, 16, 16, 16);
  const ScratchFile file;
  ASSERT_TRUE(compressTo(file.path(), sequence, {Kind::kRms, 1e-3}));
  const auto reader = VoluteReader::open(file.path());
  double before = std::numeric_limits<double>::infinity();
  for (int levels = 1; levels <= 5; ++levels) {
    std::vector<float> values(sequence.values.size());
    ASSERT_TRUE(reader->readBlock(0, values, levels));
    double sum = 0;
    for (std::size_t i = 0; i < values.size(); ++i)
      sum += std::pow(values[i] - sequence.values[i], 2);
    EXPECT_LT(sum, before) << levels;
    before = sum;
  }
}

// The mean of a block is in the index: nothing else of the block is read.
TEST(VoluteReader, TheCoarsestLevelIsTheMeanOfTheBlock) {
  for (const int channels : {1, 3}) {
    for (const Kind kind : {Kind::kRms, Kind::kLook}) {
      const Sequence sequence = plumes(21, 20, 20, 40, channels);
      const ScratchFile file;
      ASSERT_TRUE(compressTo(file.path(), sequence, {kind, 1e-3}));
      const auto reader = VoluteReader::open(file.path());
      ASSERT_TRUE(reader) << reader.error().message;
      const BlockGrid& grid = reader->blocks();
      for (std::size_t block = 0; block < grid.count(); ++block) {
        std::vector<float> coarse(grid.values(block)), fine(coarse.size());
        ASSERT_TRUE(reader->readBlock(block, coarse, 1));
        EXPECT_EQ(reader->bytesRead(), 0u);
        const auto whole = VoluteReader::open(file.path());
        ASSERT_TRUE(whole->readBlock(block, fine));
        for (std::size_t c = 0; c < static_cast<std::size_t>(channels); ++c) {
          double sum = 0, mean = 0;
          for (std::size_t i = c; i < fine.size(); i += static_cast<std::size_t>(channels))
            sum += coarse[i], mean += fine[i];
          const double voxels = static_cast<double>(fine.size()) / channels;
          EXPECT_NEAR(sum / voxels, mean / voxels, 5e-3) << block;
        }
      }
    }
  }
}

// Small bodies that fill a block in part keep their mass at each level.
TEST(VoluteReader, LevelsOfPartlyFilledBlocksHaveTheirMeans) {
  Sequence sequence = makeSequence(16, 32, 32, 32);
  auto view = sequence.view();
  for (int t = 0; t < 16; ++t)
    for (int k = 0; k < 32; ++k)
      for (int j = 0; j < 32; ++j)
        for (int i = 0; i < 32; ++i) {
          const bool sheet = k == 5 || (i % 16 == 9 && j % 16 < 7) || (i + j + k) % 29 == 0;
          view(t, k, j, i, 0) = sheet ? 1.0f + 0.02f * static_cast<float>(i + t) : 0;
        }
  const ScratchFile file;
  CompressOptions options;
  options.mode = BlockMode{true, Wavelet::kCdf53, 2};
  ASSERT_TRUE(compressTo(file.path(), sequence, {Kind::kRms, 1e-3}, options));
  const auto reader = VoluteReader::open(file.path());
  for (std::size_t block = 0; block < reader->blocks().count(); ++block) {
    std::vector<float> fine(reader->blocks().values(block)), coarse(fine.size());
    ASSERT_TRUE(reader->readBlock(block, fine));
    double whole = 0;
    for (const float value : fine) whole += value;
    for (int levels = 1; levels <= 4; ++levels) {
      ASSERT_TRUE(reader->readBlock(block, coarse, levels));
      double sum = 0;
      for (const float value : coarse) sum += value;
      EXPECT_NEAR(sum, whole, 0.02 * whole) << "block " << block << ", levels " << levels;
    }
  }
}

// A frame alone, and a row of them, are the same.
TEST(VoluteReader, AFrameIsTheSameAloneAndInItsRow) {
  for (const Access access : {Access::kFrame, Access::kFilm}) {
    const Sequence sequence = plumes(37, 17, 20, 33);
    const ScratchFile file;
    CompressOptions options;
    options.access = access;
    ASSERT_TRUE(compressTo(file.path(), sequence, {Kind::kLook, 1e-3}, options));
    const auto all = readBack(file.path());
    ASSERT_TRUE(all) << all.error().message;
    const auto reader = std::make_shared<const VoluteReader>(*VoluteReader::open(file.path()));
    for (const int frame : {36, 3, 18, 8, 30, 5}) {
      std::vector<float> alone(sequence.info.frameValues());
      ASSERT_TRUE(frameSource(reader)->readFrame(frame, alone));
      EXPECT_TRUE(std::ranges::equal(alone, all->frame(frame))) << frame;
      Bricks bricks;
      ASSERT_TRUE(frameSource(reader)->readBricks(frame, 0, 17, bricks));
      std::vector<float> dense(alone.size());
      bricks.toDense({{0, 0, 0}, {33, 20, 17}}, dense);
      EXPECT_EQ(dense, alone) << frame;
    }
  }
}

// Of such a block the levels are in two tiers, and corrections in the third.
TEST(VoluteReader, AllLevelsOfASmallBlockAreTheWholeOfIt) {
  const Sequence sequence = plumes(4, 7, 4, 4, 1, 300);
  const ScratchFile file;
  ASSERT_TRUE(compressTo(file.path(), sequence, {Kind::kMaxError, 0.01}));
  const auto reader = VoluteReader::open(file.path());
  const int levels = reader->blocks().levels(0);
  ASSERT_LT(levels, 5);
  std::vector<float> whole(sequence.values.size()), all(whole.size());
  ASSERT_TRUE(reader->readBlock(0, whole));
  ASSERT_TRUE(reader->readBlock(0, all, levels));
  EXPECT_EQ(all, whole);
}

TEST(VoluteReader, AFrameNeedsNoRowInMemory) {
  const Sequence sequence = plumes(18, 20, 20, 20);
  const ScratchFile file;
  ASSERT_TRUE(compressTo(file.path(), sequence, {Kind::kRms, 1e-2}));
  const auto all = readBack(file.path());
  const auto tight = readBack(file.path(), {false, 100000});
  ASSERT_TRUE(all && tight);
  EXPECT_EQ(all->values, tight->values);
}

// A file of so many blocks in a box of 100,000^3 voxels, whose values are nowhere.
void writeHugeFile(const std::filesystem::path& path, std::size_t blocks, FileHead& head) {
  const ScratchFile small;
  ASSERT_TRUE(compressTo(small.path(), plumes(18, 17, 9, 19), {Kind::kRms, 3e-3}));
  const auto file = InputFile::open(small.path());
  head = *readHeadAndPages(*file, std::uint64_t{1} << 30);
  VolumeInfo& info = head.info;
  info.x = info.y = info.z = 100000;
  info.frames = 200;
  info.frameNumbers.clear();
  info.times.clear();
  info.fillDefaults();
  head.blocks.clear();
  head.segments.clear();
  head.means.clear();
  std::uint64_t number = 12345;
  for (std::size_t i = 0; i < blocks; ++i) {
    head.blocks.push_back(number);
    head.means.push_back(static_cast<std::int64_t>(i * 2654435761u >> 7 & 255));
    // Runs of neighbours, then a gap as to the next line of blocks, or to the next frames.
    number += i % 7 != 0 ? 1 : i % 1001 == 0 ? std::uint64_t{6250} * 6250 * 30 : 6239 + i % 13;
  }
  for (std::size_t tier = 0; tier < 3; ++tier) {
    for (std::size_t i = 0; i < blocks; ++i)
      head.segments.push_back({0, static_cast<std::uint32_t>(40 + (i * 7919 >> 3) % 700), 0});
  }
  const auto bytes = writeHead(head);
  const auto* first = reinterpret_cast<const char*>(bytes.data());
  writeBytes(path, {first, first + bytes.size()});
  std::filesystem::resize_file(path, head.fileBytes);
}

TEST(VoluteReader, ThreeRequestsTellWhereABlockIs) {
  for (const std::size_t blocks : {1, 1000, 100000, 2000000}) {
    const ScratchFile file;
    FileHead head;
    writeHugeFile(file.path(), blocks, head);
    const auto reader = VoluteReader::open(file.path());
    ASSERT_TRUE(reader) << reader.error().message;
    EXPECT_EQ(reader->occupiedCount(), blocks);
    const std::size_t at = blocks * 2 / 3;
    std::uint64_t size = 0;
    for (std::size_t tier = 0; tier < 3; ++tier) size += head.segments[tier * blocks + at].size;
    EXPECT_EQ(reader->storedBytes(head.blocks[at]).value(), size);
    EXPECT_LE(reader->indexRequests(), 3u) << blocks;
    EXPECT_LE(reader->indexBytes(), 65536u) << blocks;
    EXPECT_EQ(reader->storedBytes(0).value(), 0u);
    const auto all = reader->occupied();
    ASSERT_TRUE(all) << all.error().message;
    EXPECT_EQ(*all, head.blocks);
    EXPECT_LE(reader->indexBytes(), 16 * blocks + 16384) << blocks;
    const auto opened = InputFile::open(file.path());
    const auto again = readHeadAndPages(*opened, std::uint64_t{1} << 30);
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_TRUE(std::ranges::equal(
        again->segments, head.segments, {},
        [](const auto& s) { return std::pair(s.offset, s.size); },
        [](const auto& s) { return std::pair(s.offset, s.size); }));
  }
}

// Written from plumes(18, 17, 9, 19, 3) at a relative RMS of 0.03: it must read the same for ever.
TEST(FrozenFile, Version1Codec2) {
  const auto path = std::filesystem::path(VOLUTE_TEST_DATA) / "version1_codec2.volute";
  const auto decoded = readBack(path);
  ASSERT_TRUE(decoded) << decoded.error().message;
  const std::span<const float> values(decoded->values);
  EXPECT_EQ(values[2000], 0.00132884516f);
  EXPECT_EQ(values[9000], 0.00275412714f);
  EXPECT_EQ(values[9001], 0);
  EXPECT_EQ(crc32(std::as_bytes(values)), 0x49A091ACu);
  EXPECT_LE(testing::differenceOf(plumes(18, 17, 9, 19, 3), *decoded).relativeRms, 0.03);
  const auto reader = VoluteReader::open(path);
  EXPECT_EQ(reader->describeBlock(0).value(), "plain cdf53, 4 time levels");
  EXPECT_EQ(reader->describeBlock(2).value(), "empty");
  EXPECT_EQ(reader->describeBlock(5).value(), "plain cdf53, 1 time level");
}

}  // namespace
}  // namespace volute
