// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "volute/grid/grid_matrix.hpp"
#include "volute/io/sequence_testing.hpp"
#include "volute/io/testing.hpp"
#include "volute/io/volume_sink.hpp"
#include "volute/io/volume_source.hpp"

namespace volute {
namespace {

using ::testing::HasSubstr;
using namespace testing;

#if VOLUTE_HAS_VDB

/// A blob whose first and last voxels are set, so that its box of active voxels is the whole
/// volume.
Sequence makeFullBlob(int frames, int z, int y, int x, int channels = 1) {
  Sequence sequence = makeBlob(frames, z, y, x, channels);
  for (int i = 0; i < frames; ++i) sequence.frame(i).front() = sequence.frame(i).back() = 0.5f;
  return sequence;
}

TEST(Vdb, RoundTripOfScalarAndRgb) {
  for (int channels : {1, 3}) {
    const TempFolder folder;
    auto written = makeFullBlob(2, 5, 9, 17, channels);
    written.info.name = "flame";
    written.info.bounds = {Vec3(-1, 2, 3), Vec3(0.7, 4.7, 3.5)};  // voxels of 0.1 x 0.3 x 0.1
    written.info.frameNumbers = {37, 40};
    written.info.times = {1.5, 1.62};
    ASSERT_TRUE(ok(writeAll(folder / "f_%04d.vdb", written)));
    EXPECT_TRUE(std::filesystem::exists(folder / "f_0037.vdb"));
    for (const auto& input : {folder / "f_%04d.vdb", folder / "f_####.vdb", folder.path()}) {
      ASSERT_VALUE(const auto read, readSequence(input));
      EXPECT_EQ(read.values, written.values);
      EXPECT_EQ(read.info.name, "flame");
      EXPECT_EQ(read.info.channels, channels);
      EXPECT_EQ(read.info.frameNumbers, written.info.frameNumbers);
      EXPECT_EQ(read.info.times, written.info.times);
      EXPECT_LT((read.info.bounds.min - written.info.bounds.min).norm(), 1e-12);
      EXPECT_LT((read.info.bounds.max - written.info.bounds.max).norm(), 1e-12);
    }
  }
}

TEST(Vdb, ExtensionsInCapitalsAreTheSame) {
  const TempFolder folder;
  const auto written = makeFullBlob(2, 5, 9, 17);
  ASSERT_TRUE(ok(writeAll(folder / "F_%04d.VDB", written)));
  for (const auto& input : {folder / "F_%04d.VDB", folder.path()}) {
    ASSERT_VALUE(const auto read, readSequence(input));
    EXPECT_EQ(read.values, written.values);
  }
}

// As OpenVDB's io::Stream and many exporters write them.
TEST(Vdb, FilesWithoutATableOfGridsAreRead) {
  constexpr std::size_t kHasOffsets = 20;  // after magic number and versions
  const TempFolder folder;
  auto written = makeFullBlob(1, 5, 9, 17);
  ASSERT_TRUE(ok(writeAll(folder / "f.vdb", written)));
  std::string bytes = readBytes(folder / "f.vdb");
  ASSERT_EQ(bytes[kHasOffsets], 1);
  bytes[kHasOffsets] = 0;
  writeBytes(folder / "stream.vdb", bytes);
  ASSERT_VALUE(const auto read, readSequence(folder / "stream.vdb"));
  EXPECT_EQ(read.values, written.values);
  EXPECT_EQ(read.info.name, written.info.name);
  for (const std::size_t size : {bytes.size() / 4, bytes.size() / 2, bytes.size() - 1}) {
    writeBytes(folder / "cut.vdb", bytes.substr(0, size));
    EXPECT_FALSE(readSequence(folder / "cut.vdb")) << size;
  }
}

TEST(Vdb, NegativeFramesAndFramesBetweenWholeOnesKeepTheirNames) {
  const TempFolder folder;
  auto written = makeFullBlob(4, 5, 9, 17);
  written.info.frameNumbers = {-200, -175, 100, 125};
  written.info.frameScale = {2, false};
  written.info.times = {0, 0.01, 0.12, 0.13};
  ASSERT_TRUE(ok(writeAll(folder / "f.%04d.vdb", written)));
  for (const char* name : {"f.-0002.vdb", "f.-0001.75.vdb", "f.0001.vdb", "f.0001.25.vdb"})
    EXPECT_TRUE(std::filesystem::exists(folder / name)) << name;
  for (const auto& input : {folder / "f.%04d.vdb", folder / "f.$F4.vdb", folder.path()}) {
    ASSERT_VALUE(const auto read, readSequence(input));
    EXPECT_EQ(read.info.frameNumbers, written.info.frameNumbers);
    EXPECT_EQ(read.info.frameScale, written.info.frameScale);
    EXPECT_EQ(read.values, written.values);
  }
}

// Leaves have 8 layers, so that these begin and end inside of some and leave others out.
TEST(Vdb, LayersAreThoseOfTheFrame) {
  for (int channels : {1, 3}) {
    const TempFolder folder;
    const auto written = makeFullBlob(2, 37, 9, 17, channels);
    ASSERT_TRUE(ok(writeAll(folder / "f_%04d.vdb", written)));
    for (const bool bounds : {false, true}) {
      SourceOptions options;
      if (bounds)
        options.bounds = written.info.bounds;
      options.byLayers = true;
      options.maxMemory = 1000;  // less than a frame
      ASSERT_VALUE(const auto source, openSource(folder.path(), options));
      ASSERT_TRUE(source->readsLayers());
      const std::size_t layer = 9 * 17 * static_cast<std::size_t>(channels);
      for (const auto& [first, end] : {std::pair{0, 16}, {16, 32}, {3, 4}, {13, 37}}) {
        std::vector<float> part(layer * static_cast<std::size_t>(end - first));
        ASSERT_TRUE(ok(source->readLayers(1, first, end, part)));
        EXPECT_TRUE(
            std::equal(part.begin(), part.end(),
                       written.frame(1).begin() + static_cast<std::ptrdiff_t>(layer * first)))
            << first << ' ' << end;
      }
    }
  }
}

TEST(Vdb, KeepsNaNAndRoundsHalves) {
  const TempFolder folder;
  auto written = makeFullBlob(1, 2, 2, 2);
  written.values[3] = std::numeric_limits<float>::quiet_NaN();
  written.values[4] = 0.1f;
  ASSERT_TRUE(ok(writeAll(folder / "a.vdb", written, {.half = true})));
  ASSERT_VALUE(const auto read, readSequence(folder / "a.vdb"));
  EXPECT_TRUE(std::isnan(read.values[3]));
  EXPECT_NEAR(read.values[4], 0.1f, 5e-5f);
  EXPECT_NE(read.values[4], 0.1f);
}

TEST(Vdb, EqualInputsGiveEqualBytes) {
  const TempFolder folder;
  const auto written = makeFullBlob(1, 4, 4, 4);
  ASSERT_TRUE(ok(writeAll(folder / "a.vdb", written)));
  ASSERT_TRUE(ok(writeAll(folder / "b.vdb", written)));
  EXPECT_TRUE(readBytes(folder / "a.vdb") == readBytes(folder / "b.vdb"));
}

/// Two frames on one lattice of 0.25 m voxels; only the voxel (x, y, z) of each is set.
void writeTwoSpots(const TempFolder& folder) {
  auto spots = makeSequence(2, 8, 8, 8);
  spots.info.bounds = {Vec3::Zero(), Vec3::Constant(2)};
  spots.info.frameNumbers = {3, 10};
  spots.info.times = {0, 0.28};
  spots.view()(0, 2, 2, 2, 0) = 1;
  spots.view()(1, 4, 3, 5, 0) = 2;
  ASSERT_TRUE(ok(writeAll(folder / "s_%d.vdb", spots)));
}

TEST(Vdb, WithoutBoundsTheUnionOfActiveVoxels) {
  const TempFolder folder;
  writeTwoSpots(folder);
  ASSERT_VALUE(const auto read, readSequence(folder.path()));
  EXPECT_EQ(read.info.x, 4);
  EXPECT_EQ(read.info.y, 2);
  EXPECT_EQ(read.info.z, 3);
  EXPECT_EQ(read.info.bounds.min, Vec3(0.5, 0.5, 0.5));
  EXPECT_EQ(read.view()(0, 0, 0, 0, 0), 1);
  EXPECT_EQ(read.view()(1, 2, 1, 3, 0), 2);
}

TEST(Vdb, BoundsCropAndPad) {
  const TempFolder folder;
  writeTwoSpots(folder);
  SourceOptions options;
  options.bounds = Box3{Vec3(-0.25, 0.75, 0), Vec3(2.5, 1, 1.25)};
  ASSERT_VALUE(const auto read, readSequence(folder.path(), options));
  EXPECT_EQ(read.info.x, 11);
  EXPECT_EQ(read.info.y, 1);
  EXPECT_EQ(read.info.z, 5);
  EXPECT_EQ(read.view()(1, 4, 0, 6, 0), 2);
  double sum = 0;
  for (float value : read.values) sum += value;
  EXPECT_EQ(sum, 2);  // the first frame's spot is cut off
}

TEST(Vdb, BoundsMustLieOnTheVoxelGrid) {
  const TempFolder folder;
  writeTwoSpots(folder);
  SourceOptions options;
  options.bounds = Box3{Vec3(0.1, 0, 0), Vec3(1, 1, 1)};
  const auto refused = openSource(folder.path(), options);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("the nearest that do are 0,0,0,1,1,1"));
  options.bounds = Box3{Vec3(0.0002, 0, 0), Vec3(1, 1, 1)};
  EXPECT_TRUE(ok(openSource(folder.path(), options)));
}

TEST(Vdb, EmptyFramesNeedABoxFromElsewhere) {
  const TempFolder folder;
  auto sequence = makeSequence(2, 3, 3, 3);
  ASSERT_TRUE(ok(writeAll(folder / "e_%d.vdb", sequence)));
  EXPECT_THAT(openSource(folder.path(), {}).error().message, HasSubstr("is empty in all 2 frames"));
  SourceOptions options;
  options.bounds = sequence.info.bounds;
  EXPECT_TRUE(ok(readSequence(folder.path(), options)));
  sequence.frame(1)[13] = 1;
  ASSERT_TRUE(ok(writeAll(folder / "e_%d.vdb", sequence)));
  ASSERT_VALUE(const auto read, readSequence(folder.path()));
  EXPECT_EQ(read.values, (std::vector<float>{0, 1}));
}

TEST(Vdb, FramesOnOtherLatticesHaveMatrices) {
  const TempFolder folder;
  auto first = makeFullBlob(1, 4, 4, 4);
  ASSERT_TRUE(ok(writeAll(folder / "f_1.vdb", first)));
  const auto placesWith = [&](const Box3& bounds) {
    first.info.bounds = bounds;
    EXPECT_TRUE(ok(writeAll(folder / "f_2.vdb", first)));
    const auto source = openSource(folder.path(), {});
    const auto* placed = source ? dynamic_cast<const PlacedFrames*>(source->get()) : nullptr;
    return placed ? placed->places() : std::vector<GridMatrix>();
  };
  const auto larger = placesWith({Vec3::Zero(), Vec3::Constant(2)});
  ASSERT_EQ(larger.size(), 2U);
  EXPECT_LT((linearOf(larger[0]) - Mat3::Identity()).norm(), 1e-12);
  EXPECT_LT((linearOf(larger[1]) - 2 * Mat3::Identity()).norm(), 1e-12);
  EXPECT_LT(offsetOf(larger[1]).norm(), 1e-12);
  const auto apart = placesWith({Vec3::Constant(0.1), Vec3::Constant(1.1)});
  ASSERT_EQ(apart.size(), 2U);
  EXPECT_LT((offsetOf(apart[1]) - Vec3::Constant(0.1)).norm(), 1e-12);
  EXPECT_TRUE(placesWith({Vec3::Constant(0.5), Vec3::Constant(1.5)}).empty());
  ASSERT_VALUE(const auto moved, readSequence(folder.path()));
  EXPECT_EQ(moved.info.x, 6);
  EXPECT_EQ(moved.view()(1, 2, 2, 2, 0), first.values.front());
}

TEST(Vdb, WrongNamesGetASuggestion) {
  const TempFolder folder;
  ASSERT_TRUE(ok(writeAll(folder / "a.vdb", makeFullBlob(1, 2, 2, 2))));
  SourceOptions options;
  options.grid = "denisty";
  const auto source = openSource(folder / "a.vdb", options);
  ASSERT_FALSE(source);
  EXPECT_EQ(source.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(source.error().message, HasSubstr("did you mean 'density'? it has density (float)"));
}

TEST(Vdb, HugeBoxesAreRefusedBeforeTheyAreAllocated) {
  const TempFolder folder;
  ASSERT_TRUE(ok(writeAll(folder / "a.vdb", makeFullBlob(1, 16, 16, 16))));
  SourceOptions options;
  options.maxMemory = 1 << 20;
  options.bounds = Box3{Vec3::Zero(), Vec3::Constant(1e7)};
  const auto far = openSource(folder / "a.vdb", options);
  ASSERT_FALSE(far);
  EXPECT_EQ(far.error().code, ErrorCode::kTooLarge);
}

TEST(Vdb, SeveralFramesNeedAPattern) {
  const auto sink = createSink("a.vdb", makeSequence(2, 2, 2, 2).info);
  ASSERT_FALSE(sink);
  EXPECT_THAT(sink.error().message, HasSubstr("a_%04d.vdb"));
}

TEST(Vdb, AFullDiskLeavesNothing) {
  const auto sequence = makeFullBlob(2, 16, 16, 16);
  expectFullDiskLeavesNothing(
      4096, [&](const TempFolder& folder) { return writeAll(folder / "a_%d.vdb", sequence); });
}

TEST(Vdb, TruncationsAreRefused) {
  const TempFolder folder;
  ASSERT_TRUE(ok(writeAll(folder / "a.vdb", makeFullBlob(1, 6, 6, 6))));
  const std::string bytes = readBytes(folder / "a.vdb");
  const auto read = [](const std::filesystem::path& file) { return readSequence(file); };
  expectCutsRefused(folder / "b.vdb", bytes, read, 1 + bytes.size() / 150);
  writeBytes(folder / "b.vdb", bytes.substr(0, bytes.size() - 1));
  EXPECT_FALSE(readSequence(folder / "b.vdb"));
}

TEST(Vdb, BitFlipsNeverCrash) {
  const TempFolder folder;
  ASSERT_TRUE(ok(writeAll(folder / "a.vdb", makeFullBlob(1, 6, 6, 6))));
  const std::string bytes = readBytes(folder / "a.vdb");
  std::mt19937 random(1);
  SourceOptions options;
  options.maxMemory = 16 << 20;
  for (int i = 0; i < 150; ++i) {
    writeBytes(folder / "b.vdb", withFlippedBit(bytes, random() % (8 * bytes.size())));
    const auto read = readSequence(folder / "b.vdb", options);
    EXPECT_TRUE(read || !read.error().message.empty());
  }
}

#else

TEST(Vdb, ABuildWithoutItSaysSo) {
  const TempFolder folder;
  writeBytes(folder / "a.vdb", "");
  EXPECT_THAT(readSequence(folder / "a.vdb").error().message,
              HasSubstr("this build has no OpenVDB"));
  EXPECT_THAT(writeAll(folder / "b.vdb", makeBlob(1, 1, 1, 1)).error().message,
              HasSubstr("VOLUTE_WITH_VDB=OFF"));
}

#endif

}  // namespace
}  // namespace volute
