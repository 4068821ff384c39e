// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/join.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <optional>

#include "volute/codec/bundle.hpp"
#include "volute/codec/codec_testing.hpp"

namespace volute {
namespace {

using namespace testing;

/// Frames [begin, end) as a sequence of its own.
Sequence partOf(const Sequence& whole, int begin, int end) {
  Sequence part;
  part.info = whole.info;
  part.info.frames = end - begin;
  part.info.frameNumbers = {whole.info.frameNumbers.begin() + begin,
                            whole.info.frameNumbers.begin() + end};
  part.info.times = {whole.info.times.begin() + begin, whole.info.times.begin() + end};
  const auto size = static_cast<std::ptrdiff_t>(whole.info.frameValues());
  part.values = {whole.values.begin() + begin * size, whole.values.begin() + end * size};
  return part;
}

/// The first half again and again: parts of it are quantised alike.
Sequence periodic(int frames) {
  Sequence sequence = plumes(frames, 10, 9, 18);
  const std::size_t half = 16 * sequence.info.frameValues();
  for (std::size_t i = half; i < sequence.values.size(); ++i)
    sequence.values[i] = sequence.values[i - half];
  return sequence;
}

struct Told final : Progress {
  void remark(const Remark& one) override { all.push_back(one); }

  std::vector<Remark> all;
};

class JoinTest : public ::testing::Test {
 protected:
  std::filesystem::path pack(const std::string& name, const Sequence& sequence, double rms = 3e-3) {
    const auto path = scratch.folder() / name;
    const auto report = testing::compressTo(path, sequence, {ErrorTarget::Kind::kRms, rms});
    EXPECT_TRUE(report) << (report ? "" : report.error().message);
    return path;
  }

  Result<JoinReport> joined(const std::vector<std::filesystem::path>& parts,
                            const JoinOptions& options = {}) {
    Progress progress;
    return join(parts, scratch.path(), options, progress);
  }

  std::string messageOf(const std::vector<std::filesystem::path>& parts) {
    const auto result = joined(parts);
    EXPECT_FALSE(std::filesystem::exists(scratch.path()));
    return result ? "" : result.error().message;
  }

  ScratchFile scratch;
};

TEST_F(JoinTest, CopiesBlocksWhereThatIsExact) {
  const Sequence whole = periodic(37);
  const auto a = pack("a.volute", partOf(whole, 0, 16)),
             b = pack("b.volute", partOf(whole, 16, 32));
  const auto report = joined({a, b});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_TRUE(report->copied);
  EXPECT_EQ(report->partsRms, 0);
  const auto first = readBack(a).value(), second = readBack(b).value();
  const auto both = readBack(scratch.path()).value();
  ASSERT_EQ(both.info.frames, 32);
  EXPECT_EQ(both.info.frameNumbers, partOf(whole, 0, 32).info.frameNumbers);
  EXPECT_EQ(both.info.times, partOf(whole, 0, 32).info.times);
  EXPECT_TRUE(std::ranges::equal(first.values, std::span(both.values).first(first.values.size())));
  EXPECT_TRUE(std::ranges::equal(second.values, std::span(both.values).last(second.values.size())));
  EXPECT_NEAR(differenceOf(partOf(whole, 0, 32), both).relativeRms, report->relativeRms, 1e-9);
  EXPECT_TRUE(VoluteReader::open(scratch.path()).value().verify().complete());
}

// Each part has a step, a table of contexts and a range of its own.
TEST_F(JoinTest, CopiesBlocksThatWereCompressedApart) {
  const Sequence whole = plumes(53, 10, 9, 18);
  const auto a = pack("a.volute", partOf(whole, 0, 16), 1e-3);
  Sequence brighter = partOf(whole, 16, 48);
  for (float& value : brighter.values) value *= 3;
  const auto b = pack("b.volute", brighter, 4e-3);
  const auto c = pack("c.volute", partOf(whole, 48, 53), 2e-3);
  const auto report = joined({b, c, a});  // in any order
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_TRUE(report->copied);
  EXPECT_EQ(report->partsRms, 0);
  const auto reader = VoluteReader::open(scratch.path()).value();
  EXPECT_TRUE(reader.verify().complete());
  const auto all = readBack(scratch.path()).value();
  std::vector<float> parts;
  std::uint64_t bytes = 0;
  for (const auto& path : {a, b, c}) {
    const auto part = readBack(path).value();
    parts.insert(parts.end(), part.values.begin(), part.values.end());
    bytes += std::filesystem::file_size(path);
  }
  EXPECT_EQ(all.values, parts);
  EXPECT_LT(report->fileBytes, bytes);
  EXPECT_EQ(report->fileBytes, std::filesystem::file_size(scratch.path()));
  // What is said of errors holds, relative to the range of the whole.
  Sequence original = whole;
  std::ranges::copy(brighter.values, original.values.begin() + 16 * static_cast<std::ptrdiff_t>(
                                                                        whole.info.frameValues()));
  const auto difference = differenceOf(original, all);
  EXPECT_NEAR(difference.relativeRms, report->relativeRms, 1e-6);
  EXPECT_NEAR(difference.maxError, report->maxError, 1e-6);
  EXPECT_EQ(reader.header().targetKind, "support-rms");
  EXPECT_EQ(reader.header().targetValue, 4e-3);
  EXPECT_LE(difference.relativeRms, reader.header().targetValue);
}

TEST_F(JoinTest, TimesThatAreMovedAreTold) {
  const Sequence whole = periodic(32);
  const auto a = pack("a.volute", partOf(whole, 0, 16));
  const auto b = pack("b.volute", partOf(whole, 16, 32));
  Sequence again = partOf(whole, 16, 32);
  for (double& time : again.info.times) time -= whole.info.times[16];
  const auto c = pack("c.volute", again);
  Told told;
  ASSERT_TRUE(join({a, b}, scratch.path(), {}, told));
  EXPECT_THAT(told.all, ::testing::IsEmpty());
  ASSERT_TRUE(join({a, c}, scratch.path(), {}, told));
  ASSERT_EQ(told.all.size(), 1U);
  EXPECT_EQ(told.all[0].code, RemarkCode::kChanged);
  EXPECT_THAT(told.all[0].sentence,
              ::testing::AllOf(::testing::HasSubstr("c.volute: begins at 0 s"),
                               ::testing::HasSubstr("moved by")));
}

TEST_F(JoinTest, PartsHaveOneUpAxis) {
  const Sequence whole = plumes(12, 4, 4, 4);
  Sequence first = partOf(whole, 0, 4), second = partOf(whole, 4, 8);
  second.info.up = 'y';
  const auto a = pack("a.volute", first), b = pack("b.volute", second);
  Told told;
  ASSERT_TRUE(join({a, b}, scratch.path(), {}, told));
  ASSERT_EQ(told.all.size(), 1U);
  EXPECT_EQ(told.all[0].code, RemarkCode::kAssumed);
  EXPECT_THAT(told.all[0].sentence, ::testing::HasSubstr("a.volute: does not say which axis"));
  EXPECT_EQ(VoluteReader::open(scratch.path()).value().info().up, 'y');
  std::filesystem::remove(scratch.path());
  Sequence third = partOf(whole, 8, 12);
  third.info.up = 'x';
  EXPECT_NE(messageOf({a, b, pack("c.volute", third)}).find("y points upwards in one and x in"),
            std::string::npos);
}

TEST_F(JoinTest, JoinedFilesCanBeJoined) {
  const Sequence whole = plumes(48, 6, 5, 7);
  const auto a = pack("a.volute", partOf(whole, 0, 16), 1e-3);
  const auto b = pack("b.volute", partOf(whole, 16, 32), 4e-3);
  const auto c = pack("c.volute", partOf(whole, 32, 48), 2e-3);
  ASSERT_TRUE(joined({a, b, c}));
  const auto atOnce = testing::readBytes(scratch.path());
  ASSERT_TRUE(joined({b, c}));
  const auto two = scratch.folder() / "two.volute";
  std::filesystem::rename(scratch.path(), two);
  ASSERT_TRUE(joined({a, two}));
  const auto inSteps = readBack(scratch.path()).value();
  testing::writeBytes(scratch.path(), atOnce);
  EXPECT_EQ(inSteps.values, readBack(scratch.path()).value().values);
}

// Whatever its bytes say, a head is refused or read; what is read decodes to finite values.
TEST_F(JoinTest, DamagedListsOfPartsAreRefused) {
  const Sequence whole = plumes(32, 4, 4, 4);
  ASSERT_TRUE(joined({pack("a.volute", partOf(whole, 0, 16), 1e-3),
                      pack("b.volute", partOf(whole, 16, 32), 4e-3)}));
  const auto bytes = testing::readBytes(scratch.path());
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    testing::writeBytes(scratch.path(), testing::withFlippedBit(bytes, 8 * i + i % 8));
    const auto opened = VoluteReader::open(scratch.path());
    EXPECT_TRUE(!opened || !opened->verify().complete()) << i;
  }
}

TEST_F(JoinTest, EncodesAgainWherePartsEndWithinABlock) {
  const Sequence whole = plumes(32, 10, 9, 18);
  const auto a = pack("a.volute", partOf(whole, 0, 15), 1e-3);
  const auto b = pack("b.volute", partOf(whole, 15, 32), 4e-3);
  const auto report = joined({b, a}, {.rms = 1e-3});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_FALSE(report->copied);
  EXPECT_LE(report->partsRms, 1e-3);
  const auto difference = differenceOf(whole, readBack(scratch.path()).value());
  EXPECT_LE(difference.relativeRms, report->relativeRms * 1.001);
  EXPECT_LE(difference.maxError, report->maxError * 1.001);
  const auto header = VoluteReader::open(scratch.path()).value().header();
  // The decoded parts do not quite reach the range of the originals.
  EXPECT_NEAR(header.reachedRms, report->relativeRms, 1e-5);
}

TEST_F(JoinTest, PartsNeedNotEndWithABlock) {
  const Sequence whole = periodic(37);
  const auto report =
      joined({pack("a.volute", partOf(whole, 0, 5)), pack("b.volute", partOf(whole, 5, 24)),
              pack("c.volute", partOf(whole, 24, 37))});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_FALSE(report->copied);
  const auto both = readBack(scratch.path()).value();
  EXPECT_EQ(both.info.frameNumbers, whole.info.frameNumbers);
  EXPECT_LE(differenceOf(whole, both).relativeRms, report->relativeRms * 1.001);
  EXPECT_LT(report->relativeRms, 7e-3);
}

TEST_F(JoinTest, TimesThatBeginAnewGoOn) {
  const Sequence whole = plumes(8, 4, 4, 4);
  Sequence late = partOf(whole, 4, 8);
  const double start = late.info.times.front();
  for (double& time : late.info.times) time -= start;
  ASSERT_TRUE(joined({pack("a.volute", partOf(whole, 0, 4)), pack("b.volute", late)}));
  const auto times = readBack(scratch.path()).value().info.times;
  for (std::size_t i = 0; i < times.size(); ++i) EXPECT_NEAR(times[i], whole.info.times[i], 1e-12);
}

TEST_F(JoinTest, RefusesWhatDoesNotFit) {
  const Sequence whole = plumes(8, 4, 4, 4);
  const auto a = pack("a.volute", partOf(whole, 0, 4));
  EXPECT_NE(messageOf({a, pack("b.volute", partOf(whole, 3, 8))}).find("do not overlap"),
            std::string::npos);
  EXPECT_NE(messageOf({a, a}).find("frames 0 to 3"), std::string::npos);
  Sequence wider = partOf(plumes(8, 4, 4, 5), 4, 8);
  EXPECT_NE(messageOf({a, pack("c.volute", wider)}).find("5 x 4 x 4 voxels"), std::string::npos);
  Sequence moved = partOf(whole, 4, 8);
  moved.info.bounds.max.z() += 0.5;
  EXPECT_NE(messageOf({a, pack("d.volute", moved)}).find("do not fit together"), std::string::npos);
  Sequence other = partOf(whole, 4, 8);
  other.info.basis = Basis::kTrilinear;
  EXPECT_NE(messageOf({a, pack("e.volute", other)}).find("trilinear basis"), std::string::npos);
  EXPECT_NE(messageOf({a, scratch.folder() / "none.volute"}).find("none.volute"),
            std::string::npos);
  EXPECT_EQ(messageOf({}), "there is nothing to join; expected .volute files");
}

TEST_F(JoinTest, DamagedPartsAreRefused) {
  const Sequence whole = periodic(37);
  const auto a = pack("a.volute", partOf(whole, 0, 16)),
             b = pack("b.volute", partOf(whole, 16, 32));
  auto bytes = testing::readBytes(b);
  bytes[bytes.size() - 20] ^= 4;
  testing::writeBytes(b, bytes);
  EXPECT_NE(messageOf({a, b}).find("b.volute: is damaged"), std::string::npos);
}

// Files of several grids, as caches are compressed.
class JoinGridsTest : public JoinTest {
 protected:
  struct Grid {
    std::string name;
    std::optional<Sequence> sequence;  // none: it is empty
    GridDescription::Index begin{};
  };

  std::filesystem::path packGrids(const std::string& name, const std::vector<Grid>& grids,
                                  int frames) {
    std::vector<BundledGrid> bundled;
    for (const Grid& grid : grids) {
      BundledGrid& row = bundled.emplace_back();
      row.name = grid.name;
      row.description.emplace();
      row.description->voxelSize = {0.5, 0.5, 0.5};
      row.description->begin = grid.begin;
      row.description->background = {0.25, 0, 0};
      row.description->voxels = grid.begin[0] + 7;
      for (int i = 0; i < frames; ++i) {
        const MetadataList list{{"from", "string", name}};
        row.description->metadata.add(&list);
      }
      if (grid.sequence)
        row.file = pack("grid_" + grid.name + "_" + name, *grid.sequence);
    }
    Progress progress;
    const auto path = scratch.folder() / name;
    const auto written = bundle(bundled, {}, path, progress);
    EXPECT_TRUE(written) << (written ? "" : written.error().message);
    return path;
  }

  /// Some voxels of all, at their place in it.
  static Sequence cropped(const Sequence& whole, int beginX, int endX) {
    Sequence part = makeSequence(whole.info.frames, whole.info.z, whole.info.y, endX - beginX, 1);
    const double voxel = whole.info.voxelSize().x();
    part.info.bounds = whole.info.bounds;
    part.info.bounds.min.x() = whole.info.bounds.min.x() + beginX * voxel;
    part.info.bounds.max.x() = whole.info.bounds.min.x() + endX * voxel;
    part.info.frameNumbers = whole.info.frameNumbers;
    part.info.times = whole.info.times;
    for (std::size_t line = 0; line < whole.values.size() / whole.info.x; ++line) {
      std::copy_n(whole.values.begin() + static_cast<std::ptrdiff_t>(line * whole.info.x + beginX),
                  endX - beginX,
                  part.values.begin() + static_cast<std::ptrdiff_t>(line * part.info.x));
    }
    return part;
  }

  static VoluteReader gridOf(const std::filesystem::path& path, const std::string& name) {
    VoluteReader::Options options;
    options.grid = name;
    return VoluteReader::open(path, options).value();
  }

  static Sequence valuesOf(const std::filesystem::path& path, const std::string& name) {
    const auto source = frameSource(std::make_shared<const VoluteReader>(gridOf(path, name)));
    return readAll(*source, std::uint64_t{1} << 30).value();
  }
};

TEST_F(JoinGridsTest, BlocksOfEachGridAreCopied) {
  const Sequence whole = periodic(37);
  const Sequence other = plumes(37, 12, 9, 10);
  const auto a = packGrids(
      "a.volute", {{"density", partOf(whole, 0, 16)}, {"flame", partOf(other, 0, 16)}}, 16);
  const auto b = packGrids(
      "b.volute", {{"density", partOf(whole, 16, 37)}, {"flame", partOf(other, 16, 37)}}, 21);
  const auto report = joined({b, a});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_TRUE(report->copied);
  EXPECT_EQ(report->info.frames, 37);
  EXPECT_EQ(report->fileBytes, std::filesystem::file_size(scratch.path()));
  for (const char* name : {"density", "flame"}) {
    const auto first = valuesOf(a, name), second = valuesOf(b, name),
               both = valuesOf(scratch.path(), name);
    EXPECT_EQ(both.info.frameNumbers, whole.info.frameNumbers);
    EXPECT_TRUE(
        std::ranges::equal(first.values, std::span(both.values).first(first.values.size())));
    EXPECT_TRUE(
        std::ranges::equal(second.values, std::span(both.values).last(second.values.size())));
  }
  const auto reader = gridOf(scratch.path(), "flame");
  ASSERT_EQ(reader.grids().size(), 2u);
  const FrameMetadata& metadata = reader.grids()[1].description->metadata;
  ASSERT_EQ(metadata.listOf.size(), 37u);
  EXPECT_EQ(metadata.at(15)->front().value, "a.volute");
  EXPECT_EQ(metadata.at(16)->front().value, "b.volute");
}

// Shorter blocks let files of any multiple of their frames be copied.
TEST(Join, BlocksOfOneLengthAreCopied) {
  const Sequence whole = plumes(24, 9, 10, 12);
  const ScratchFile scratch("joined.volute");
  const auto packed = [&](const char* name, int begin, int end, Access access) {
    CompressOptions options;
    options.access = access;
    const auto path = scratch.folder() / name;
    EXPECT_TRUE(testing::compressTo(path, partOf(whole, begin, end),
                                    {ErrorTarget::Kind::kRms, 1e-3}, options));
    return path;
  };
  Progress progress;
  const auto first = packed("a.volute", 0, 12, Access::kFrame);
  const auto second = packed("b.volute", 12, 24, Access::kFrame);
  const auto copied = join({first, second}, scratch.path(), {}, progress);
  ASSERT_TRUE(copied) << copied.error().message;
  EXPECT_TRUE(copied->copied);
  const auto all = readBack(scratch.path()), a = readBack(first), b = readBack(second);
  EXPECT_TRUE(std::ranges::equal(a->values, std::span(all->values).first(a->values.size())));
  EXPECT_TRUE(std::ranges::equal(b->values, std::span(all->values).last(b->values.size())));
  const auto long16 = packed("c.volute", 12, 24, Access::kFilm);
  const auto again = join({first, long16}, scratch.path(), {}, progress);
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_FALSE(again->copied);
}

// What grows in one file and is not there yet in another.
TEST_F(JoinGridsTest, GridsThatGrowHaveTheBackgroundElsewhere) {
  const Sequence whole = plumes(32, 9, 10, 24);
  const Sequence early = cropped(partOf(whole, 0, 16), 8, 16);
  const Sequence late = cropped(partOf(whole, 16, 32), 4, 24);
  const auto a =
      packGrids("a.volute", {{"density", early, {8, 0, 0}}, {"flame", std::nullopt}}, 16);
  const auto b =
      packGrids("b.volute", {{"flame", late, {4, 0, 0}}, {"density", late, {4, 0, 0}}}, 16);
  JoinOptions options;
  options.rms = 1e-4;
  const auto report = joined({a, b}, options);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_FALSE(report->copied);
  const auto reader = gridOf(scratch.path(), "density");
  EXPECT_EQ(reader.info().x, 20);
  EXPECT_EQ(reader.grids()[0].description->begin, (GridDescription::Index{4, 0, 0}));
  EXPECT_EQ(reader.grids()[0].description->voxels, 15u);
  EXPECT_NEAR(reader.info().bounds.min.x(), late.info.bounds.min.x(), 1e-9);
  const auto was = valuesOf(a, "density"), is = valuesOf(scratch.path(), "density");
  EXPECT_NEAR(is.view()(3, 4, 5, 0, 0), 0.25, report->maxError + 1e-6);
  EXPECT_NEAR(is.view()(3, 4, 5, 4 + 2, 0), was.view()(3, 4, 5, 2, 0), report->maxError + 1e-6);
  const auto flame = valuesOf(scratch.path(), "flame");
  EXPECT_EQ(flame.info.frames, 32);
  EXPECT_EQ(flame.info.x, 20);
  EXPECT_NEAR(flame.view()(15, 4, 5, 6, 0), 0.25, report->maxError + 1e-6);
  EXPECT_FALSE(gridOf(scratch.path(), "flame").grids()[1].description->metadata.at(0)->empty());
}

TEST_F(JoinGridsTest, GridsOfAnotherKindAreRefused) {
  const Sequence whole = plumes(32, 9, 10, 12), fine = plumes(16, 9, 10, 11);
  const auto a = packGrids("a.volute", {{"density", partOf(whole, 0, 16)}}, 16);
  Sequence other = partOf(whole, 16, 32);
  other.info.bounds.max *= 1.37;
  const auto b = packGrids("b.volute", {{"density", other}}, 16);
  EXPECT_THAT(messageOf({a, b}), ::testing::HasSubstr("do not fit together"));
}

}  // namespace
}  // namespace volute
