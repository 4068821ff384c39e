// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "volute/grid/brick_slice.hpp"
#include "volute/grid/bricks.hpp"
#include "volute/grid/sequence.hpp"

namespace volute {
namespace {

TEST(VolumeInfo, DefaultsAreCubicVoxelsOneMetreAnd25FramesPerSecond) {
  VolumeInfo info;
  info.frames = 3, info.z = 10, info.y = 20, info.x = 40;
  info.frameNumbers = {5, 6, 8};
  info.fillDefaults();
  EXPECT_DOUBLE_EQ(info.bounds.size().x(), 1);
  EXPECT_DOUBLE_EQ(info.bounds.size().z(), 0.25);
  EXPECT_DOUBLE_EQ(info.times[2], 3 / 25.0);
  EXPECT_EQ(info.frameAt(-1), 0);
  EXPECT_EQ(info.frameAt(0.041), 1);
  EXPECT_EQ(info.frameAt(99), 2);
  EXPECT_TRUE(info.validate("test"));
  info.times[1] = 0;
  EXPECT_FALSE(info.validate("test"));
}

TEST(BrickSlice, KeepsEveryValueAndNoEmptyBrick) {
  Sequence sequence = makeSequence(1, 9, 17, 8, 3);
  auto view = sequence.view();
  view(0, 8, 16, 7, 2) = 5;
  view(0, 0, 0, 0, 0) = 1;
  view(0, 0, 1, 1, 1) = 2;
  const BrickSlice slice = BrickSlice::fromDense(sequence.info, sequence.frame(0));
  for (const bool byLayers : {false, true}) {
    const std::size_t layer = sequence.info.frameValues() / sequence.info.z;
    const auto read = BrickSlice::fromLayers(
        sequence.info, byLayers, [&](int first, int end, std::span<float> values) -> Status {
          EXPECT_TRUE(byLayers || end - first == sequence.info.z);
          const auto from = sequence.frame(0).subspan(first * layer, (end - first) * layer);
          std::ranges::copy(from, values.begin());
          return {};
        });
    ASSERT_TRUE(read);
    EXPECT_TRUE(std::ranges::equal(read->values(), slice.values()));
    EXPECT_EQ(read->storedBricks(), slice.storedBricks());
  }
  EXPECT_EQ(slice.storedBricks(), 2u);
  for (int z = 0; z < 9; ++z)
    for (int y = 0; y < 17; ++y)
      for (int x = 0; x < 8; ++x)
        for (int c = 0; c < 3; ++c) ASSERT_EQ(slice.value(x, y, z, c), view(0, z, y, x, c));
  EXPECT_EQ(slice.value(-1, 0, 0), 0);
}

TEST(BrickSlice, HalvedHasTheMeansOfEightVoxels) {
  Sequence sequence = makeSequence(1, 19, 33, 8, 3);
  auto view = sequence.view();
  for (int z : {0, 7, 8, 18})
    for (int y = 0; y < 33; y += 2)
      for (int x = 1; x < 8; ++x) view(0, z, y, x, 1) = static_cast<float>(z + 2 * y + 3 * x);
  const BrickSlice slice = BrickSlice::fromDense(sequence.info, sequence.frame(0));
  const BrickSlice half = slice.halved(1);
  EXPECT_EQ(half.channels(), 1);
  const Vec3 voxels(half.x(), half.y(), half.z());
  EXPECT_EQ(voxels, Vec3(4, 17, 10));
  const Vec3 voxel = sequence.info.voxelSize();
  EXPECT_NEAR((half.bounds().max - half.bounds().min - 2 * voxel.cwiseProduct(voxels)).norm(), 0,
              1e-12);
  for (int z = 0; z < 10; ++z)
    for (int y = 0; y < 17; ++y)
      for (int x = 0; x < 4; ++x) {
        float sum = 0;
        for (int i = 0; i < 8; ++i)
          sum += slice.value(2 * x + i % 2, 2 * y + i / 2 % 2, 2 * z + i / 4, 1);
        ASSERT_FLOAT_EQ(half.value(x, y, z), sum / 8);
      }
}

/// Leaves that lie across bricks and beyond the volume, and tiles of which parts are whole bricks.
TEST(BrickSlice, HoldsWhatIsInAFrame) {
  VolumeInfo info;
  info.x = 61, info.y = 70, info.z = 33;
  info.channels = 3;
  for (const std::int64_t offset : {0, -3, 5}) {
    Bricks bricks(3);
    for (const VoxelIndex& origin : {VoxelIndex{offset, offset, offset},
                                     {offset + 8, offset, offset},
                                     {offset + 56, 64, 16}}) {
      auto values = bricks.addLeaf({origin});
      for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(1 + i % 97);
    }
    bricks.addTile({{offset + 16, offset + 16, offset}, 32, true, {2, 3, 4}});
    bricks.addTile({{offset + 48, offset + 48, offset}, 8, false, {7, 0, 0}});
    bricks.addTile({{0, 0, 64}, 64, true, {9, 9, 9}});     // outside
    bricks.addLeaf({{offset + 16, offset, offset + 24}});  // active zeros
    bricks.sort();
    std::vector<float> dense(info.frameValues());
    bricks.toDense({{0, 0, 0}, {info.x, info.y, info.z}}, dense);
    const BrickSlice slice = BrickSlice::fromBricks(info, bricks);
    const BrickSlice unshared = slice.unshared();
    std::size_t i = 0;
    for (int z = 0; z < info.z; ++z)
      for (int y = 0; y < info.y; ++y)
        for (int x = 0; x < info.x; ++x)
          for (int c = 0; c < 3; ++c, ++i) {
            ASSERT_EQ(slice.value(x, y, z, c), dense[i]) << x << ' ' << y << ' ' << z;
            ASSERT_EQ(unshared.value(x, y, z, c), dense[i]);
          }
    EXPECT_EQ(unshared.storedBricks(), BrickSlice::fromDense(info, dense).storedBricks());
    EXPECT_LT(slice.storedBricks(), unshared.storedBricks());
    EXPECT_EQ(slice.entries().size(), unshared.storedBricks());
  }
}

TEST(BrickTable, IsAsLargeAsWhatIsInIt) {
  for (const int side : {1, 8, 40, 200, 12500, 1 << 27}) {
    std::vector<BrickPlace> places;
    std::mt19937 random(5);
    for (int i = 0; i < 200; ++i)
      places.push_back({static_cast<int>(random() % side), static_cast<int>(random() % side),
                        static_cast<int>(random() % side)});
    std::ranges::sort(places, isBefore);
    places.erase(std::unique(places.begin(), places.end()), places.end());
    BrickTable table({side, side, side}, places.size());
    for (std::size_t i = 0; i < places.size(); ++i)
      table.set(places[i], static_cast<std::int32_t>(i));
    EXPECT_LT(table.bytes(), 5'000'000U);
    for (std::size_t i = 0; i < places.size(); ++i) {
      ASSERT_EQ(table.at(places[i]), static_cast<std::int32_t>(i));
      const auto [x, y, z] = places[i];
      const auto there = std::ranges::find(places, BrickPlace{x + 1, y, z});
      ASSERT_EQ(table.at(x + 1, y, z),
                there == places.end() ? -1 : static_cast<std::int32_t>(there - places.begin()));
    }
    EXPECT_EQ(table.at(-1, 0, side), BrickTable::kEmpty);
    // From corner to corner, past those on the diagonal.
    const BrickPlace middle{side / 2, side / 2, side / 2};
    table.set(middle, 7777);
    std::vector<std::int32_t> seen;
    double last = 0;
    table.walk({Vec3::Zero(), Vec3::Ones(), {}},
               {Vec3::Constant(-1), Vec3::Ones().normalized(), 0, 1e12},
               [&](const BrickPlace& place, std::int32_t number, double begin, double end) {
                 EXPECT_EQ(table.at(place), number);
                 EXPECT_LE(last, begin);
                 EXPECT_NEAR(begin, std::sqrt(3) * (place[0] + 1), 1e-6 * side + 1e-9);
                 last = end;
                 seen.push_back(number);
                 return true;
               });
    EXPECT_TRUE(std::ranges::find(seen, 7777) != seen.end()) << side;
  }
}

TEST(ReadAll, RefusesWhatDoesNotFit) {
  const Sequence sequence = makeSequence(4, 8, 8, 8);
  SequenceSource source(sequence);
  EXPECT_TRUE(readAll(source, 8192));
  const auto refused = readAll(source, 8191);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kTooLarge);
}

}  // namespace
}  // namespace volute
