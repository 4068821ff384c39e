// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/grid_cache.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "volute/io/sequence_testing.hpp"
#include "volute/io/testing.hpp"
#include "volute/io/volume_sink.hpp"

namespace volute {
namespace {

using ::testing::HasSubstr;
using namespace testing;

#if VOLUTE_HAS_VDB

/// A grid whose first and last voxels are set, with a lattice of its own.
GridTarget gridOf(Sequence& sequence, std::string name, double voxel, const Vec3& origin,
                  std::array<std::int64_t, 3> begin) {
  sequence.info.name = std::move(name);
  sequence.info.frameNumbers.clear(), sequence.info.times.clear();
  for (int i = 0; i < sequence.info.frames; ++i) {
    sequence.frame(i).front() = sequence.frame(i).back() = 0.25F;
    sequence.info.frameNumbers.push_back(7 + 2 * i);
  }
  sequence.info.times.clear();
  sequence.info.fillDefaults();
  GridTarget target{sequence.info, {}};
  GridDescription& grid = target.description;
  grid.type = sequence.info.channels == 3 ? "vec3s" : "float";
  grid.map = "UniformScaleTranslateMap";
  grid.voxelSize = {voxel, voxel, voxel};
  grid.origin = {origin.x(), origin.y(), origin.z()};
  grid.begin = begin;
  return target;
}

/// A frame of a level set with the background 1: what is inside of its band is -1 and not active.
Bricks bandOf(const Sequence& sequence, int frame) {
  Bricks bricks = Bricks::fromDense(sequence.info, sequence.frame(frame), {1, 1, 1});
  for (std::size_t i = 0; i < bricks.leaves().size(); ++i) {
    for (std::size_t voxel = 0; voxel < Bricks::kVoxels; ++voxel) {
      if (bricks.values(i)[voxel] == -1)
        bricks.leaf(i).active[voxel / 64] &= ~(std::uint64_t{1} << voxel % 64);
    }
  }
  return bricks;
}

struct CacheInput {
  CacheInput()
      : density(makeBlob(2, 5, 6, 7)),
        velocity(makeBlob(2, 3, 4, 5, 3)),
        solid(makeBlob(2, 9, 9, 9)) {
    targets.push_back(gridOf(density, "density", 0.1, {1, 2, 3}, {-4, 0, 11}));
    targets.back().description.gridClass = "fog volume";
    targets.back().description.half = true;
    targets.push_back(gridOf(velocity, "velocity", 0.2, {0, 0, 0}, {1, 2, 3}));
    targets.back().description.gridClass = "staggered";
    targets.back().description.map = "UniformScaleMap";
    const MetadataList constant{{"cell", "vec3i", std::string("\1\0\0\0\2\0\0\0\3\0\0\0", 12)},
                                {"vector_type", "string", "contravariant relative"}};
    MetadataList later = constant;  // sorted by names, as OpenVDB has them
    later.insert(later.begin() + 1, {"step", "int32", std::string("\7\0\0\0", 4)});
    targets.back().description.metadata.add(&constant);
    targets.back().description.metadata.add(&later);
    // A sphere: distances in the band, what is beyond it says which side it is on.
    targets.push_back(gridOf(solid, "solid", 0.5, {9, 9, 9}, {0, 0, 0}));
    targets.back().description.gridClass = "level set";
    targets.back().description.background = {1, 0, 0};
    for (int t = 0; t < 2; ++t) {
      for (int i = 0; i < 729; ++i) {
        const Vec3 at(i % 9 - 4, i / 9 % 9 - 4, i / 81 - 4);
        solid.frame(t)[static_cast<std::size_t>(i)] =
            static_cast<float>(std::clamp(0.5 * (at.norm() - 3), -1.0, 1.0));
      }
    }
    GridTarget empty = targets[0];
    empty.info.name = "flame";
    empty.info.x = empty.info.y = empty.info.z = 0;
    // The second frame has no such grid at all.
    const MetadataList none;
    empty.description.metadata.add(&none);
    empty.description.metadata.add(nullptr);
    targets.push_back(empty);
    const MetadataList file{{"made_by", "string", "a test"}};
    fileMetadata.add(&file);
    fileMetadata.add(&file);
  }

  Status write(const std::filesystem::path& pattern) {
    VOLUTE_ASSIGN(auto sink, createCacheSink(pattern, targets, fileMetadata));
    for (int t = 0; t < 2; ++t) {
      std::vector<Bricks> values;
      for (const Sequence* one : {&density, &velocity})
        values.push_back(Bricks::fromDense(one->info, one->frame(t)));
      values.push_back(bandOf(solid, t));
      values.emplace_back();
      VOLUTE_TRY(sink->writeFrame(values));
    }
    return sink->finish();
  }

  Sequence density, velocity, solid;
  std::vector<GridTarget> targets;
  FrameMetadata fileMetadata;
};

Result<Sequence> readGrid(const GridCache& cache, std::size_t grid) {
  VOLUTE_ASSIGN(auto source, cache.source(grid));
  return readAll(*source, 1 << 30);
}

TEST(GridCache, WhatIsWrittenIsReadBackWithAllThatItSays) {
  const TempFolder folder;
  CacheInput input;
  ASSERT_TRUE(ok(input.write(folder / "c_%04d.vdb")));
  ASSERT_VALUE(const auto cache, GridCache::open(folder.path(), {}));
  ASSERT_EQ(cache.grids().size(), 4u);
  EXPECT_EQ(cache.fileMetadata(), input.fileMetadata);
  for (std::size_t i = 0; i < 3; ++i) {
    const GridDescription& read = cache.grids()[i].description;
    const GridDescription& written = input.targets[i].description;
    EXPECT_EQ(cache.grids()[i].name, input.targets[i].info.name);
    EXPECT_EQ(read.type, written.type);
    EXPECT_EQ(read.gridClass, written.gridClass);
    EXPECT_EQ(read.half, written.half);
    EXPECT_EQ(read.map, written.map);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(read.voxelSize[axis], written.voxelSize[axis], 1e-15);
      EXPECT_NEAR(read.origin[axis], written.origin[axis], 1e-15);
    }
    EXPECT_EQ(read.background, written.background);
    EXPECT_FALSE(cache.grids()[i].empty);
    EXPECT_GT(read.voxels, 0u);
  }
  EXPECT_EQ(cache.grids()[1].description.metadata, input.targets[1].description.metadata);
  EXPECT_EQ(cache.grids()[0].description.metadata.lists[0][0].name, "is_saved_as_half_float");
  EXPECT_EQ(cache.grids()[0].description.begin, input.targets[0].description.begin);
  EXPECT_TRUE(cache.grids()[3].empty);
  EXPECT_EQ(cache.grids()[3].description.metadata.listOf, (std::vector{0, -1}));

  ASSERT_VALUE(const auto velocity, readGrid(cache, 1));
  EXPECT_EQ(velocity.values, input.velocity.values);
  EXPECT_EQ(velocity.info.frameNumbers, (std::vector{7, 9}));
  EXPECT_NEAR(velocity.info.bounds.min.x(), 0.1, 1e-12);
  ASSERT_VALUE(const auto density, readGrid(cache, 0));
  ASSERT_EQ(density.values.size(), input.density.values.size());
  for (std::size_t i = 0; i < density.values.size(); ++i)  // halves
    EXPECT_NEAR(density.values[i], input.density.values[i], 5e-4 * input.density.values[i] + 1e-7);
  // Both sides of the sphere, within the box of its band.
  ASSERT_VALUE(const auto solid, readGrid(cache, 2));
  EXPECT_EQ(std::ranges::min(solid.values), -1);
  const auto& begin = cache.grids()[2].description.begin;
  for (int z = 0; z < solid.info.z; ++z)
    for (int y = 0; y < solid.info.y; ++y)
      for (int x = 0; x < solid.info.x; ++x)
        EXPECT_EQ(solid.view()(0, z, y, x, 0),
                  input.solid.view()(0, z + begin[2], y + begin[1], x + begin[0], 0));
}

TEST(GridCache, TopologyIsThatOfTheFile) {
  const TempFolder folder;
  CacheInput input;
  input.targets.resize(1);
  input.fileMetadata = {};
  GridTarget& target = input.targets[0];
  target.info.x = target.info.y = target.info.z = 200;
  target.info.frames = 1;
  target.info.frameNumbers = {0};
  target.info.times = {0};
  target.info.bounds = {};
  target.info.fillDefaults();
  target.description.begin = {-8, 0, 16};
  target.description.half = false;
  target.description.background = {0.25, 0, 0};
  Bricks bricks(1, {0.25F, 0, 0});
  // A tile of a node of its own, one that is not active, and a leaf of all kinds of voxels.
  bricks.addTile({{8, 128, 112}, 8, true, {2, 0, 0}});
  bricks.addTile({{136, 0, 112}, 8, false, {-1, 0, 0}});
  Bricks::Leaf leaf{{0, 0, 0}};
  leaf.active[0] = 0b0111;  // the second is the background, and active
  leaf.valued[0] = 0b1111;
  const std::span<float> values = bricks.addLeaf(leaf);
  values[0] = 1, values[2] = 0, values[3] = 3;
  bricks.addLeaf({{192, 192, 184}, {0, 0, 0, 0, 0, 0, 0, 1}, {0, 0, 0, 0, 0, 0, 0, 1}})[448] = 7;
  bricks.sort();
  ASSERT_VALUE(auto sink, createCacheSink(folder / "c_%04d.vdb", input.targets, {}));
  ASSERT_TRUE(ok(sink->writeFrame(std::vector{bricks})));
  ASSERT_TRUE(ok(sink->finish()));
  ASSERT_VALUE(const auto cache, GridCache::open(folder / "c_%04d.vdb", {}));
  ASSERT_VALUE(auto source, cache.source(0));
  EXPECT_EQ(source->info().z, 176 + 16);
  Bricks back;
  ASSERT_TRUE(ok(source->readBricks(0, back)));
  EXPECT_EQ(back.background(), bricks.background());
  EXPECT_EQ(back.checksum(), bricks.checksum());
  // A part of it has the same tiles and leaves where it has any.
  ASSERT_TRUE(ok(source->readBricks(0, 116, 192, back)));
  ASSERT_EQ(back.tiles().size(), 2u);
  EXPECT_EQ(back.tiles()[0], bricks.tiles()[0]);
  ASSERT_EQ(back.leaves().size(), 1u);
  EXPECT_EQ(back.leaves()[0].active, bricks.leaves()[1].active);
}

TEST(GridCache, AGridThatMovesComesBackWhereItWas) {
  const TempFolder folder;
  CacheInput input;
  input.targets.resize(1);
  input.fileMetadata = {};
  input.targets[0].description.shifts = {{0, 0, 0}, {2, -1, 0}};
  {
    ASSERT_VALUE(auto sink, createCacheSink(folder / "c_%04d.vdb", input.targets, {}));
    for (int t = 0; t < 2; ++t) {
      const std::vector values{Bricks::fromDense(input.density.info, input.density.frame(t))};
      ASSERT_TRUE(ok(sink->writeFrame(values)));
    }
    ASSERT_TRUE(ok(sink->finish()));
  }
  ASSERT_VALUE(const auto cache, GridCache::open(folder / "c_%04d.vdb", {}));
  EXPECT_EQ(cache.grids()[0].description.shifts, input.targets[0].description.shifts);
  ASSERT_VALUE(const auto back, readGrid(cache, 0));
  EXPECT_EQ(back.info.x, input.density.info.x);
  EXPECT_EQ(back.info.y, input.density.info.y);
}

TEST(GridCache, WhatAFileSaysIsNotTrusted) {
  const TempFolder folder;
  CacheInput input;
  GridDescription& grid = input.targets[0].description;
  const MetadataList odd{{"", "string", "x"},           {"a", "int32", "12345"},
                         {"b", "no such type", "1"},    {"name", "string", "another"},
                         {"c", "__delayedload", "123"}, {"d", "mat4d", ""}};
  grid.metadata.add(&odd);
  grid.metadata.add(&odd);
  ASSERT_TRUE(ok(input.write(folder / "c_%04d.vdb")));
  ASSERT_VALUE(const auto cache, GridCache::open(folder.path(), {}));
  EXPECT_EQ(cache.grids()[0].name, "density");
  // That it is half, and the bytes of a type that nobody knows.
  EXPECT_EQ(cache.grids()[0].description.metadata.lists[0].size(), 2u);
  grid.begin[0] = std::int64_t{1} << 39;
  const Status far = input.write(folder / "d_%04d.vdb");
  ASSERT_FALSE(far);
  EXPECT_THAT(far.error().message, HasSubstr("too far"));
  grid.begin[0] = 0;
  grid.voxelSize = {0, -1, NAN};  // the bounds serve
  ASSERT_TRUE(ok(input.write(folder / "d_%04d.vdb")));
}

#endif

}  // namespace
}  // namespace volute
