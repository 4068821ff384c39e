// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/bricks.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "volute/grid/sequence.hpp"

namespace volute {
namespace {

Sequence blob(int z, int y, int x, int channels) {
  Sequence sequence = makeSequence(1, z, y, x, channels);
  std::mt19937 random(7);
  for (float& value : sequence.values) {
    const unsigned number = random();
    value = number % 5 == 0 ? static_cast<float>(number % 100) / 7 : 0;
  }
  return sequence;
}

IndexBox boxOf(const VolumeInfo& info) {
  return {{0, 0, 0}, {info.x, info.y, info.z}};
}

TEST(Bricks, DenseFramesComeBack) {
  for (const int channels : {1, 3}) {
    const Sequence sequence = blob(19, 9, 21, channels);
    const Bricks bricks = Bricks::fromDense(sequence.info, sequence.values);
    std::vector<float> values(sequence.values.size());
    bricks.toDense(boxOf(sequence.info), values);
    EXPECT_EQ(values, sequence.values);
    std::uint64_t active = 0;
    for (std::size_t i = 0; i < values.size(); i += static_cast<std::size_t>(channels))
      active += std::any_of(&values[i], &values[i] + channels, [](float v) { return v != 0; });
    EXPECT_EQ(bricks.activeVoxels(), active);
    const auto origins = bricks.leaves();
    for (std::size_t i = 0; i < origins.size(); ++i) EXPECT_EQ(bricks.find(origins[i].origin), i);
    EXPECT_EQ(bricks.find({8, 8, 800}), origins.size());
  }
}

TEST(Bricks, LayersTogetherAreTheFrame) {
  const Sequence sequence = blob(24, 8, 8, 1);
  const std::size_t layer = 64;
  const auto part = [&](int first, int end) {
    return Bricks::fromLayers(
        sequence.info, first, end,
        std::span(sequence.values).subspan(first * layer, (end - first) * layer));
  };
  Bricks all = part(0, 16);
  all.append(part(16, 24));
  const Bricks whole = Bricks::fromDense(sequence.info, sequence.values);
  EXPECT_EQ(all.checksum(), whole.checksum());
}

TEST(Bricks, AddingLeavesMovesValuesRarely) {
  Bricks bricks;
  const float* last = nullptr;
  int moves = 0;
  for (int i = 0; i < 2000; ++i) {
    const float* values = bricks.addLeaf({{8 * i, 0, 0}}).data() - Bricks::kVoxels * i;
    moves += values != last;
    last = values;
  }
  EXPECT_LT(moves, 20);
}

TEST(Bricks, OneVoxelInAnEmptyBackground) {
  Bricks bricks(1, {0.3f, 0, 0});
  Bricks::Leaf leaf{{1'000'000'000'000, -16, 8}};
  leaf.active[3] = leaf.valued[3] = std::uint64_t{1} << (8 * 5 + 2);
  bricks.addLeaf(leaf)[64 * 3 + 8 * 5 + 2] = 2;
  EXPECT_EQ(bricks.activeVoxels(), 1u);
  std::vector<float> values(8);
  bricks.toDense({{1'000'000'000'001, -12, 10}, {1'000'000'000'003, -10, 12}}, values);
  EXPECT_EQ(values, (std::vector<float>{.3f, .3f, .3f, .3f, .3f, .3f, .3f, 2}));
}

TEST(Bricks, TilesAreConstantAndCount) {
  Bricks bricks;
  bricks.addTile({{0, 0, 0}, 4096, true, {0.5f, 0, 0}});
  EXPECT_EQ(bricks.activeVoxels(), std::uint64_t{1} << 36);
  std::vector<float> values(27);
  bricks.toDense({{4095, 4095, 4095}, {4098, 4098, 4098}}, values);
  EXPECT_EQ(values[0], 0.5f);
  EXPECT_EQ(std::count(values.begin(), values.end(), 0.0f), 26);
}

TEST(Bricks, CroppedVoxelsAreBackground) {
  const Sequence sequence = blob(16, 16, 16, 1);
  Bricks bricks = Bricks::fromDense(sequence.info, sequence.values);
  const IndexBox box{{3, 5, 7}, {12, 9, 15}};
  bricks.crop(box);
  std::vector<float> values(sequence.values.size());
  bricks.toDense(boxOf(sequence.info), values);
  std::uint64_t active = 0;
  for (int z = 0; z < 16; ++z)
    for (int y = 0; y < 16; ++y)
      for (int x = 0; x < 16; ++x) {
        const std::size_t at = static_cast<std::size_t>((z * 16 + y) * 16 + x);
        const float expected = box.contains(VoxelIndex{x, y, z}) ? sequence.values[at] : 0;
        EXPECT_EQ(values[at], expected);
        active += expected != 0;
      }
  EXPECT_EQ(bricks.activeVoxels(), active);
}

TEST(Bricks, MessagesComeBackAndDamageIsFound) {
  const Sequence sequence = blob(9, 10, 11, 3);
  Bricks bricks = Bricks::fromDense(sequence.info, sequence.values);
  bricks.addTile({{-128, 0, 0}, 128, false, {1, 2, 3}});
  bricks.sort();
  std::vector<std::byte> message(bricks.messageBytes());
  bricks.toMessage(message);
  const auto back = Bricks::fromMessage(message);
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(back->checksum(), bricks.checksum());
  for (std::size_t size = 0; size < message.size(); size += 97)
    EXPECT_FALSE(Bricks::fromMessage(std::span(message).first(size))) << size;
  const auto damaged = [&](std::size_t at, std::byte value) {
    auto bytes = message;
    bytes[at] = value;
    return !Bricks::fromMessage(bytes);
  };
  EXPECT_TRUE(damaged(7, std::byte{0x7F}));     // leaves
  EXPECT_TRUE(damaged(36, std::byte{2}));       // channels
  EXPECT_TRUE(damaged(40 + 24, std::byte{1}));  // the side of a tile
  bricks.setLeftOut(7);
  bricks.toMessage(message);
  EXPECT_EQ(Bricks::fromMessage(message)->leftOut(), 7U);
}

TEST(Bricks, MessagesKeepTheTileUnderALeaf) {
  Bricks bricks(1, {0.5f});
  Bricks::Leaf leaf;
  leaf.origin = {4, 0, 0};
  leaf.active[0] = leaf.valued[0] = 128;
  bricks.addLeaf(leaf)[7] = 2;
  bricks.addTile({{0, 0, 0}, 8, false, {-0.5f}});
  bricks.sort();
  bricks.fillUnderTiles();
  std::vector<std::byte> message(bricks.messageBytes());
  bricks.toMessage(message);
  const auto back = Bricks::fromMessage(message);
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(back->values(0)[0], -0.5f);
  EXPECT_EQ(back->checksum(), bricks.checksum());
}

TEST(Bricks, VoxelsOfBoxesBeyondAllNumbers) {
  const std::int64_t far = std::int64_t{1} << 40;
  EXPECT_EQ(voxelsIn({{0, 0, 0}, {far, far, far}}), std::numeric_limits<std::uint64_t>::max());
  EXPECT_EQ(voxelsIn({{0, 0, 0}, {100'000, 100'000, 100'000}}), 1'000'000'000'000'000u);
  EXPECT_EQ(voxelsIn({{0, 0, 0}, {1, 0, 1}}), 0u);
}

}  // namespace
}  // namespace volute
