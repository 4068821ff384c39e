// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/resample.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "volute/grid/grid_description.hpp"
#include "volute/grid/one_frame_testing.hpp"
#include "volute/grid/sequence.hpp"
#include "volute/grid/vector_kind.hpp"
#include "volute/math/rotation.hpp"

namespace volute {
namespace {

constexpr std::uint64_t kMemory = std::uint64_t{1} << 30;

/// 24^3 voxels of 0.1 m whose values are linear in their places, at least 1.
Sequence ramp(int channels = 1) {
  Sequence sequence = makeSequence(1, 24, 24, 24, channels);
  sequence.info.bounds = {Vec3::Zero(), Vec3::Constant(2.4)};
  std::size_t at = 0;
  for (int z = 0; z < 24; ++z)
    for (int y = 0; y < 24; ++y)
      for (int x = 0; x < 24; ++x)
        for (int c = 0; c < channels; ++c)
          sequence.values[at++] = static_cast<float>(1 + 0.1 * x + 0.2 * y + 0.3 * z + c);
  return sequence;
}

std::unique_ptr<FrameSource> rampSource(int channels = 1) {
  static const Sequence grey = ramp(), colours = ramp(3);
  return std::make_unique<SequenceSource>(channels == 3 ? colours : grey);
}

GridMatrix turnedBy(double angle, double voxel, const Vec3& centre) {
  const Mat3 turn = turnAbout(Vec3(1, 2, 3).normalized(), angle);
  return gridMatrix(voxel * turn, centre);
}

double sumOf(const Bricks& bricks) {
  double sum = 0;
  for (std::size_t i = 0; i < bricks.leaves().size(); ++i)
    for (const float value : bricks.values(i)) sum += value;
  for (const Bricks::Tile& tile : bricks.tiles())
    sum += tile.value[0] * std::pow(static_cast<double>(tile.side), 3);
  return sum;
}

Bricks read(FrameSource& source) {
  Bricks bricks;
  const Status status = source.readBricks(0, bricks);
  EXPECT_TRUE(status) << (status ? "" : status.error().message);
  return bricks;
}

TEST(Resample, WhatIsLinearStaysExactOnTurnedVoxels) {
  const GridMatrix matrix = turnedBy(0.5, 0.07, {1.2, 1.2, 1.2});
  const Lattice lattice{matrix, {{-8, -8, -8}, {8, 8, 8}}};
  const auto source = resampleTo(rampSource(), {}, lattice, Basis::kTrilinear, kMemory);
  std::vector<float> values(source->info().frameValues());
  ASSERT_TRUE(source->readFrame(0, values));
  std::size_t at = 0;
  for (int z = -8; z < 8; ++z)
    for (int y = -8; y < 8; ++y)
      for (int x = -8; x < 8; ++x) {
        const Vec3 index =
            (linearOf(matrix) * Vec3(x, y, z) + offsetOf(matrix)) / 0.1 - Vec3::Constant(0.5);
        EXPECT_NEAR(values[at++], 1 + 0.1 * index.x() + 0.2 * index.y() + 0.3 * index.z(), 2e-6);
      }
}

/// Components that are each linear in the place of their own face stay so where voxels have another
/// size, or go to the centres of turned ones.
TEST(Resample, StaggeredComponentsStayOnTheirFaces) {
  Sequence faces = ramp(3);
  const auto at = [](const Vec3& place, int c) {
    return 1 + place[0] + 2 * place[1] + 3 * place[2] + c;
  };
  std::size_t n = 0;
  for (int z = 0; z < 24; ++z)
    for (int y = 0; y < 24; ++y)
      for (int x = 0; x < 24; ++x)
        for (int c = 0; c < 3; ++c) {
          const Vec3 centre = 0.1 * (Vec3(x, y, z) + Vec3::Constant(0.5));
          faces.values[n++] = static_cast<float>(at(centre - 0.05 * Vec3::Unit(c), c));
        }
  const GridMatrix coarse = gridMatrix(0.2 * Mat3::Identity(), Vec3::Constant(0.1));
  const GridMatrix fine = gridMatrix(0.04 * Mat3::Identity(), Vec3::Constant(0.55));
  for (const auto& [matrix, components] :
       {std::pair(coarse, Components::kAtFaces), std::pair(fine, Components::kAtFaces),
        std::pair(turnedBy(0.5, 0.07, {1.2, 1.2, 1.2}), Components::kFacesToCentres)}) {
    const Lattice lattice{matrix, {{2, 2, 2}, {8, 8, 8}}};
    const auto source = resampleTo(std::make_unique<SequenceSource>(faces), {}, lattice,
                                   Basis::kTrilinear, kMemory, {}, {}, components);
    std::vector<float> values(source->info().frameValues());
    ASSERT_TRUE(source->readFrame(0, values));
    std::size_t v = 0;
    for (int z = 2; z < 8; ++z)
      for (int y = 2; y < 8; ++y)
        for (int x = 2; x < 8; ++x)
          for (int c = 0; c < 3; ++c) {
            const double aside = components == Components::kAtFaces ? 0.5 : 0;
            const Vec3 index = Vec3(x, y, z) - aside * Vec3::Unit(c);
            ASSERT_NEAR(values[v++], at(linearOf(matrix) * index + offsetOf(matrix), c), 1e-5);
          }
  }
}

TEST(Resample, BackAgainIsWhatItWas) {
  // From voxels that are turned to ones along the axes.
  const GridMatrix matrix = turnedBy(-0.7, 1, Vec3(3, 1, 2));
  const Lattice lattice{gridMatrix(0.1 * Mat3::Identity(), Vec3(3, 1, 2)),
                        {{-6, -6, -6}, {6, 6, 6}}};
  const auto source = resampleTo(
      rampSource(),
      {gridMatrix(linearOf(matrix), Vec3(3, 1, 2) - linearOf(matrix) * Vec3::Constant(1.2))},
      lattice, Basis::kTrilinear, kMemory);
  std::vector<float> values(source->info().frameValues());
  ASSERT_TRUE(source->readFrame(0, values));
  const Vec3 index =
      (linearOf(matrix).transpose() * Vec3(0.3, -0.2, 0.4) + Vec3::Constant(1.2)) / 0.1 -
      Vec3::Constant(0.5);
  EXPECT_NEAR(values[((4 + 6) * 12 + (-2 + 6)) * 12 + 3 + 6],
              1 + 0.1 * index.x() + 0.2 * index.y() + 0.3 * index.z(), 1e-5);
}

TEST(Resample, TheSumStaysWhereVoxelsGrow) {
  for (const Basis basis : {Basis::kBox, Basis::kTrilinear, Basis::kCubic}) {
    for (const double factor : {2.0, 3.0}) {
      // Everything that the basis reaches.
      const auto source =
          resampleTo(rampSource(), {},
                     {gridMatrix(0.1 * factor * Mat3::Identity(), Vec3::Constant(0.05 * factor)),
                      {{-3, -3, -3}, {20, 20, 20}}},
                     basis, kMemory);
      const double old = 24 * 24 * 24 * (1 + 0.6 * 11.5);
      EXPECT_NEAR(sumOf(read(*source)) * factor * factor * factor / old, 1, 1e-5)
          << factor << ' ' << basisName(basis);
    }
  }
}

VolumeInfo wide() {
  VolumeInfo info = makeSequence(1, 1, 1, 1, 1).info;
  info.x = info.y = info.z = 100'000;
  info.bounds = {Vec3::Zero(), Vec3::Constant(100'000)};
  return info;
}

Bricks sparse(float background = 0) {
  Bricks bricks(1, {background});
  Bricks::Leaf leaf{{96'000, 8, 16}};
  leaf.active[3] = leaf.valued[3] = 0xF0;
  const auto values = bricks.addLeaf(leaf);
  for (std::size_t i = 4; i < 8; ++i) values[64 * 3 + i] = 5;
  bricks.addTile({{16, 16, 16}, 8, true, {2}});
  bricks.addTile({{128, 128, 256}, 128, false, {3}});
  bricks.sort();
  return bricks;
}

TEST(Resample, OneLatticeKeepsLeavesAndTiles) {
  const Lattice same{gridMatrix(Mat3::Identity(), Vec3::Constant(0.5)),
                     {{0, 0, 0}, {100'000, 100'000, 100'000}}};
  auto source = resampleTo(std::make_unique<gridtest::OneFrame>(wide(), sparse()), {}, same,
                           Basis::kTrilinear, kMemory);
  EXPECT_EQ(read(*source).checksum(), sparse().checksum());
  // Moved by whole voxels: a lattice whose index 0 is elsewhere.
  const Lattice moved{gridMatrix(Mat3::Identity(), Vec3(16.5, 16.5, 16.5)), {{0, 0, 0}, {8, 8, 8}}};
  source = resampleTo(std::make_unique<gridtest::OneFrame>(wide(), sparse()), {}, moved,
                      Basis::kTrilinear, kMemory);
  const Bricks part = read(*source);
  ASSERT_EQ(part.tiles().size(), 1U);
  EXPECT_EQ(part.tiles()[0].origin, (VoxelIndex{0, 0, 0}));
  EXPECT_TRUE(part.leaves().empty());
}

TEST(Resample, WhatNewVoxelsLeaveOutIsCounted) {
  // 4 voxels of a leaf, a tile of 8^3 and one of 128^3 are there.
  const auto countedBy = [](double voxel, const IndexBox& box) {
    VoxelsCut counted;
    const Lattice lattice{gridMatrix(voxel * Mat3::Identity(), Vec3::Constant(0.5 * voxel)), box};
    auto source =
        resampleTo(std::make_unique<gridtest::OneFrame>(wide(), sparse()), {}, lattice, Basis::kBox,
                   kMemory, {}, [&](int, const VoxelsCut& cut) { counted = cut; });
    read(*source);
    return counted;
  };
  constexpr std::uint64_t kTiles = 8 * 8 * 8 + 128 * 128 * 128;
  VoxelsCut cut = countedBy(1, {{0, 0, 0}, {100'000, 100'000, 100'000}});
  EXPECT_EQ(cut.all, kTiles + 4);
  EXPECT_EQ(cut.outside, 0);
  cut = countedBy(2, {{0, 0, 0}, {1'000, 1'000, 1'000}});
  EXPECT_EQ(cut.all, kTiles + 4);
  EXPECT_EQ(cut.outside, 4);
  // Half of the large tile, all of the small one.
  cut = countedBy(1, {{64, 64, 64}, {192, 100'000, 100'000}});
  EXPECT_EQ(cut.outside, 4 + 8 * 8 * 8 + 128 * 128 * 64);
}

TEST(Resample, SparseFramesStaySparse) {
  // Voxels of half the size: 8 times as many.
  const Lattice half{gridMatrix(0.5 * Mat3::Identity(), Vec3::Constant(0.25)),
                     {{0, 0, 0}, {200'000, 200'000, 200'000}}};
  auto source = resampleTo(std::make_unique<gridtest::OneFrame>(wide(), sparse(1)), {}, half,
                           Basis::kBox, kMemory);
  const Bricks made = read(*source);
  EXPECT_EQ(made.background()[0], 1);
  EXPECT_EQ(made.activeVoxels(), 8u * (512 + 4));
  const IndexBox box{{192'000, 16, 32}, {192'016, 32, 48}};
  std::vector<float> values(16 * 16 * 16);
  made.toDense(box, values);
  EXPECT_EQ(values[(6 * 16 + 1) * 16 + 8], 5);
  EXPECT_EQ(values[(6 * 16 + 1) * 16 + 7], 1);
  EXPECT_EQ(values[(8 * 16 + 1) * 16 + 8], 1);
  made.toDense({{256, 256, 512}, {257, 257, 513}}, std::span(values).first(1));
  EXPECT_EQ(values[0], 3);
}

TEST(Resample, TooMuchIsRefusedBeforeItIsMade) {
  const Lattice fine{gridMatrix(1e-3 * Mat3::Identity(), Vec3::Zero()),
                     {{0, 0, 0}, {1'000'000, 1'000'000, 1'000'000}}};
  const auto source = resampleTo(std::make_unique<gridtest::OneFrame>(wide(), sparse()), {}, fine,
                                 Basis::kTrilinear, 1 << 20);
  Bricks bricks;
  const Status status = source->readBricks(0, bricks);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::kTooLarge);
}

TEST(Resample, VectorsAlongTheGridTurnAsTheirTypeSays) {
  using enum VectorKind::Type;
  const Mat3 linear = Mat3(0, -2, 0, 1, 0, 0, 0, 0, 4);
  EXPECT_TRUE(vectorTurn(kInvariant, linear).isIdentity());
  EXPECT_TRUE(vectorTurn(kUnstated, linear).isApprox(linear));
  EXPECT_TRUE(vectorTurn(kContravariantRelative, linear).isApprox(linear));
  // A gradient stands on the surfaces of what it is one of.
  const Vec3 along(1, 2, 0), gradient(-2, 1, 0.5);
  EXPECT_NEAR((vectorTurn(kCovariant, linear) * gradient).dot(linear * along), gradient.dot(along),
              1e-12);
  const MetadataList said{{"vector_type", "string", "covariant normalize"},
                          {"is_local_space", "bool", std::string(1, '\1')}};
  EXPECT_EQ(vectorKindOf(said), (VectorKind{kCovariantNormalize, true}));
  EXPECT_EQ(vectorKindOf({}), VectorKind());
  const Lattice turned{gridMatrix(0.1 * Mat3::Identity(), Vec3::Constant(0.05)),
                       {{4, 4, 4}, {8, 8, 8}}};
  const Mat3 quarter = turnAbout(Vec3::UnitZ(), M_PI / 2);
  const auto source = resampleTo(rampSource(3), {}, turned, Basis::kTrilinear, kMemory, {quarter});
  std::vector<float> values(source->info().frameValues());
  ASSERT_TRUE(source->readFrame(0, values));
  const float first = 1 + 0.6F * 4;
  EXPECT_NEAR(values[0], -(first + 1), 1e-5);
  EXPECT_NEAR(values[1], first, 1e-5);
  EXPECT_NEAR(values[2], first + 2, 1e-5);
}

}  // namespace
}  // namespace volute
