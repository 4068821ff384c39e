// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/volume/volume_motion.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "volute/io/testing.hpp"
#include "volute/io/volume_sink.hpp"
#include "volute/math/rotation.hpp"
#include "volute/media/volume/volume_medium.hpp"

namespace volute {
namespace {

using ::testing::HasSubstr;
using volute::testing::TempFolder;

constexpr int kLong = 40, kWide = 16;
constexpr double kMoved = 12;  // [voxels] along x, from a frame to the next

VolumeInfo longVolume(int channels) {
  VolumeInfo info;
  info.x = kLong, info.y = info.z = kWide;
  info.channels = channels;
  info.frames = 2;
  info.bounds = {Vec3::Zero(), Vec3(kLong, kWide, kWide) * 0.1};
  info.frameNumbers = {1, 2};
  info.fillDefaults();
  return info;
}

/// A ball that is 1 in its middle, `along` voxels from the left.
std::vector<float> blob(double along) {
  std::vector<float> values;
  for (int z = 0; z < kWide; ++z) {
    for (int y = 0; y < kWide; ++y) {
      for (int x = 0; x < kLong; ++x) {
        const double r = (Vec3(x, y, z) - Vec3(along, 7.5, 7.5)).squaredNorm();
        values.push_back(static_cast<float>(std::exp(-r / 6)));
      }
    }
  }
  return values;
}

std::vector<float> dense(const BrickSlice& slice) {
  std::vector<float> values;
  for (int z = 0; z < slice.z(); ++z)
    for (int y = 0; y < slice.y(); ++y)
      for (int x = 0; x < slice.x(); ++x) values.push_back(slice.value(x, y, z, 0));
  return values;
}

Velocities velocitiesOf(std::span<const float> values) {
  return {std::make_shared<const BrickSlice>(BrickSlice::fromDense(longVolume(3), values))};
}

double furthest(std::span<const float> a, std::span<const float> b) {
  double most = 0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max<double>(most, std::abs(a[i] - b[i]));
  return most;
}

TEST(VolumeMotion, AMovedBlobIsBetweenItsPlaces) {
  const VolumeInfo info = longVolume(1);
  const auto before = blob(12), after = blob(12 + kMoved);
  std::vector<float> velocity(3 * info.voxels(), 0);
  for (std::size_t i = 0; i < info.voxels(); ++i) velocity[3 * i] = 2;
  const BrickSlice first = BrickSlice::fromDense(info, before),
                   second = BrickSlice::fromDense(info, after);
  const Velocities moving = velocitiesOf(velocity);
  const Mat3 step = Vec3(kMoved / 2, 1, 1).asDiagonal();
  for (const double share : {0.25, 0.5, 0.9}) {
    const VoxelPaths paths = pathsBetween(info, moving, moving, step, step, {share});
    auto out = dense(blendFrames(info, first, second, {share}, &paths));
    // Its frames are interpolated between voxels where it moves by parts of one.
    EXPECT_LT(furthest(out, blob(12 + share * kMoved)), share == 0.9 ? 0.06 : 1e-5) << share;
    out = dense(blendFrames(info, first, second, {share}, nullptr));
    EXPECT_GT(furthest(out, blob(12 + share * kMoved)), 0.25);  // a ghost of each
    for (std::size_t i = 0; i < out.size(); ++i)
      ASSERT_NEAR(out[i], (1 - share) * before[i] + share * after[i], 1e-6);
  }
}

TEST(VolumeMotion, WhatMovesFurtherThanItIsWideIsThereBetween) {
  const VolumeInfo info = longVolume(1);
  constexpr double kFar = 24;
  const auto frameAt = [&](double along) {  // values and velocities end where the ball does
    std::vector<float> values, velocity;
    for (int z = 0; z < kWide; ++z) {
      for (int y = 0; y < kWide; ++y) {
        for (int x = 0; x < kLong; ++x) {
          const bool in = (Vec3(x, y, z) - Vec3(along, 8, 8)).norm() < 4;
          values.push_back(in ? 1 : 0);
          velocity.insert(velocity.end(), {in ? 1.0F : 0.0F, 0, 0});
        }
      }
    }
    return std::pair(values, velocity);
  };
  const auto [before, vBefore] = frameAt(8);
  const auto [after, vAfter] = frameAt(8 + kFar);
  const Mat3 step = Vec3(kFar, 1, 1).asDiagonal();
  for (const double share : {0.25, 0.5, 0.75}) {
    const VoxelPaths paths =
        pathsBetween(info, velocitiesOf(vBefore), velocitiesOf(vAfter), step, step, {share});
    const auto out = dense(blendFrames(info, BrickSlice::fromDense(info, before),
                                       BrickSlice::fromDense(info, after), {share}, &paths));
    EXPECT_LT(furthest(out, frameAt(8 + share * kFar).first), 1e-6) << share;
  }
}

TEST(VolumeMotion, PathsFollowVelocitiesThatChange) {
  // v = x / 10 [voxels a second]: d = -share (x + d) / 10 before, d = (1 - share) (x + d) / 10
  // after.
  const VolumeInfo info = longVolume(3);
  std::vector<float> velocity(3 * info.voxels(), 0);
  for (std::size_t i = 0; i < info.voxels(); ++i)
    velocity[3 * i] = 0.1F * static_cast<float>(i % kLong);
  const Velocities growing = velocitiesOf(velocity);
  const VoxelPaths paths =
      pathsBetween(info, growing, growing, Mat3::Identity(), Mat3::Identity(), {0.5});
  for (const int x : {5, 15, 30}) {
    const std::size_t at = paths.table.at(x / 8, 0, 0) * 512 + (7 * 8 + 7) * 8 + x % 8;
    EXPECT_NEAR(paths.from[at][0], -0.05 * x / 1.05, 1e-4);
    EXPECT_NEAR(paths.to[at][0], 0.05 * x / 0.95, 1e-4);
    EXPECT_EQ(paths.from[at][1], 0);
  }
}

TEST(VolumeMotion, NothingIsMadeWhereNothingIsOrMoves) {
  VolumeInfo info = longVolume(1);
  info.x = info.y = info.z = 100000;
  std::vector<BrickPlace> near{{0, 0, 0}}, far{{12000, 12000, 12000}};
  BrickSlice before(info, near), after(info, far);
  before.brick(0)[0] = 1, after.brick(0)[511] = 1;
  const BrickSlice middle = blendFrames(info, before, after, {0.25}, nullptr);
  EXPECT_EQ(middle.storedBricks(), 2U);
  EXPECT_EQ(middle.value(0, 0, 0), 0.75F);
  EXPECT_EQ(middle.value(96007, 96007, 96007), 0.25F);
  EXPECT_LT(middle.bytes(), 1U << 20);
}

/// A cache of the moved blob, with a grid of velocities or without; empty: there is no OpenVDB.
/// @param unit  what [m/s] are in it
/// @param turn  of the grids, and so of the velocities
/// @param said  of the velocities; those that are local are in voxels along the grid's axes
std::string writeBlobs(const TempFolder& folder, bool moving, double unit = 1,
                       const Mat3& turn = Mat3::Identity(), const MetadataList& said = {}) {
  std::vector<GridTarget> targets;
  const auto add = [&](std::string name, int channels) {
    GridTarget target{longVolume(channels), {}};
    target.info.name = std::move(name);
    target.description.type = channels == 3 ? "vec3s" : "float";
    target.description.map = "UniformScaleTranslateMap";
    target.description.voxelSize = {0.1, 0.1, 0.1};
    target.description.origin = {0.05, 0.05, 0.05};
    if (turn != Mat3::Identity())
      target.description.matrices.assign(2, gridMatrix(0.1 * turn, Vec3(3, 2, 1)));
    targets.push_back(target);
  };
  add("density", 1);
  if (moving)
    add("Velocity", 3);
  for (int frame = 0; moving && frame < 2; ++frame) targets[1].description.metadata.add(&said);
  const bool local = vectorKindOf(said).local;
  const std::string pattern = folder / "blob_%04d.vdb";
  auto sink = createCacheSink(pattern, targets, {});
  if (!sink && sink.error().code == ErrorCode::kUnsupported)
    return "";
  if (!sink)
    return sink.error().message;
  for (int frame = 0; frame < 2; ++frame) {
    // 12 voxels of 0.1 m in 1/25 s.
    std::vector<float> velocity(3 * longVolume(1).voxels(), 0);
    const Vec3 speed = local ? Vec3(12 * 25, 0, 0) : Vec3(12 * 0.1 * 25 / unit * turn.col(0));
    for (std::size_t i = 0; i < velocity.size(); ++i)
      velocity[i] = static_cast<float>(speed[i % 3]);
    std::vector values{Bricks::fromDense(targets[0].info, blob(12 + frame * kMoved))};
    if (moving)
      values.push_back(Bricks::fromDense(targets[1].info, velocity));
    if (!(*sink)->writeFrame(values))
      return "a frame";
  }
  return (*sink)->finish() ? pattern : "the end";
}

std::vector<float> shownAt(VolumeMedium& layer, double time) {
  const auto slice = layer.sliceAt(layer.framePositionAt(time));
  return slice ? dense(**slice) : std::vector<float>();
}

TEST(VolumeMotion, ALayerMovesAlongTheVelocitiesOfItsFile) {
  const TempFolder folder;
  const std::string file = writeBlobs(folder, true);
  if (file.empty())
    GTEST_SKIP() << "built without OpenVDB";
  Progress progress;
  Reading reading{progress, 1 << 30};
  InputOptions input;
  input.grid = "density";
  input.bounds = longVolume(1).bounds;
  const auto show = [&](Interpolation how, double time) {
    Appearance appearance;
    appearance.interpolation = how;
    auto layer = VolumeMedium::open(file, input, appearance, reading);
    EXPECT_TRUE(layer) << layer.error().message;
    return layer ? shownAt(**layer, time) : std::vector<float>();
  };
  const double middle = 0.5 / 25;
  const auto expected = blob(12 + kMoved / 2);
  for (const auto how : {Interpolation::kVelocity, Interpolation::kAuto}) {
    const auto moved = show(how, middle);
    ASSERT_EQ(moved.size(), expected.size());
    EXPECT_LT(furthest(moved, expected), 1e-4);
  }
  EXPECT_GT(furthest(show(Interpolation::kLinear, middle), expected), 0.6);
  EXPECT_LT(furthest(show(Interpolation::kNone, middle), blob(12)), 1e-6);
  EXPECT_LT(furthest(show(Interpolation::kVelocity, 0), blob(12)), 1e-6);
  EXPECT_LT(furthest(show(Interpolation::kVelocity, 7), blob(12 + kMoved)), 1e-6);
}

/// The same puff with its velocities in other units, and in grids that are turned or sheared.
TEST(VolumeMotion, VelocitiesHaveAUnitAndAreThoseOfTheWorld) {
  Mat3 sheared = turnAbout(Vec3(1, 2, 3).normalized(), M_PI / 6);
  sheared = sheared * Mat3(1, 0.4, 0, 0, 1, 0.2, 0, 0, 1);
  const Mat3 turned = turnAbout(Vec3::UnitZ(), M_PI / 2);

  struct Case {
    VelocityUnit unit;
    double size;  // [m/s]
  };

  Progress progress;
  Reading reading{progress, 1 << 30};
  for (const Mat3& turn : {Mat3(Mat3::Identity()), turned, sheared}) {
    for (const Case& one :
         {Case{VelocityUnit::kMetresPerSecond, 1}, Case{VelocityUnit::kMetresPerFrame, 25},
          Case{VelocityUnit::kVoxelsPerFrame, 2.5}}) {
      const bool voxels = one.unit == VelocityUnit::kVoxelsPerFrame;
      if (voxels && turn != Mat3::Identity())
        continue;
      const TempFolder folder;
      const std::string file = writeBlobs(folder, true, one.size, turn);
      if (file.empty())
        GTEST_SKIP() << "built without OpenVDB";
      Appearance appearance;
      appearance.interpolation = Interpolation::kVelocity;
      appearance.velocityUnit = one.unit;
      InputOptions input;
      input.grid = "density";
      auto layer = VolumeMedium::open(file, input, appearance, reading);
      ASSERT_TRUE(layer) << layer.error().message;
      const auto moved = shownAt(**layer, 0.5 / 25), expected = blob(12 + kMoved / 2);
      ASSERT_EQ(moved.size(), expected.size());
      EXPECT_LT(furthest(moved, expected), 1e-4) << turn << ' ' << one.size;
    }
  }
}

class Remarks : public Progress {
 public:
  void remark(const Remark& said) override {
    if (said.code == RemarkCode::kDoubtful)
      said_.push_back(said);
  }

  std::vector<Remark> said_;
};

/// A wrong unit is told with the one in which the frames fit, once.
TEST(VolumeMotion, AWrongUnitOfVelocitiesIsTold) {
  using enum VelocityUnit;
  constexpr double kSizes[] = {1, 2.5, 25};  // in the order of the units
  InputOptions input;
  input.grid = "density";
  for (const VelocityUnit truth : {kMetresPerSecond, kVoxelsPerFrame, kMetresPerFrame}) {
    const TempFolder folder;
    const auto at = static_cast<std::size_t>(truth);
    const std::string file = writeBlobs(folder, true, kSizes[at]);
    if (file.empty())
      GTEST_SKIP() << "built without OpenVDB";
    for (const VelocityUnit stated : {kMetresPerSecond, kVoxelsPerFrame, kMetresPerFrame}) {
      Remarks remarks;
      Reading reading{remarks, 1 << 30};
      Appearance appearance;
      appearance.interpolation = Interpolation::kVelocity;
      appearance.velocityUnit = stated;
      auto layer = VolumeMedium::open(file, input, appearance, reading);
      ASSERT_TRUE(layer) << layer.error().message;
      for (const double time : {0.3 / 25, 0.5 / 25}) shownAt(**layer, time);
      ASSERT_EQ(remarks.said_.size(), stated == truth ? 0 : 1) << at;
      if (stated == truth)
        continue;
      EXPECT_THAT(remarks.said_[0].sentence,
                  HasSubstr("frames 1 and 2 fit together along 'Velocity' in " +
                            std::string(kVelocityUnits[at]) + ", not in "));
      ASSERT_EQ(remarks.said_[0].hints.size(), 1u);
      EXPECT_EQ(remarks.said_[0].hints[0].value, kVelocityUnits[at]);
    }
  }
  // What no unit explains.
  const TempFolder folder;
  const std::string file = writeBlobs(folder, true, 1e-4);
  Remarks remarks;
  Reading reading{remarks, 1 << 30};
  Appearance appearance;
  appearance.interpolation = Interpolation::kVelocity;
  auto layer = VolumeMedium::open(file, input, appearance, reading);
  ASSERT_TRUE(layer) << layer.error().message;
  shownAt(**layer, 0.5 / 25);
  EXPECT_TRUE(remarks.said_.empty());  // nor is it in place that they fit
}

GridMetadata textOf(std::string name, std::string text) {
  return {std::move(name), "string", std::move(text)};
}

/// Vectors are of the world, or along the grid's axes; and turn with the volume in a scene, or not.
TEST(VolumeMotion, VectorsTurnAsTheirTypeSays) {
  const Mat3 turned = turnAbout(Vec3(1, 2, 3).normalized(), M_PI / 6);
  const GridMetadata local{"is_local_space", "bool", std::string(1, '\1')};
  const auto type = [](std::string name) { return textOf("vector_type", std::move(name)); };
  Progress progress;
  Reading reading{progress, 1 << 30};
  InputOptions input;
  input.grid = "density";

  struct Case {
    MetadataList said;
    Mat3 scene;
    bool moves;  ///< as the puff does
  };

  const Mat3 quarter = turnAbout(Vec3::UnitX(), M_PI / 2) * turnAbout(Vec3::UnitZ(), M_PI / 2);
  const Mat3 stretched = Vec3(2, 1, 3).asDiagonal();
  for (const Case& one :
       {Case{{}, quarter, true}, Case{{local}, quarter, true},
        Case{{type("contravariant relative")}, quarter, true},
        Case{{type("contravariant relative"), local}, Mat3::Identity(), true},
        Case{{type("covariant")}, quarter, true}, Case{{type("covariant")}, stretched, false},
        Case{{type("invariant")}, stretched, true}}) {
    const TempFolder folder;
    const std::string file = writeBlobs(folder, true, 1, turned, one.said);
    if (file.empty())
      GTEST_SKIP() << "built without OpenVDB";
    Appearance appearance;
    appearance.interpolation = Interpolation::kVelocity;
    if (one.scene == stretched)
      appearance.placement.scale = Vec3(2, 1, 3);
    else
      appearance.placement.turn = one.scene;
    auto layer = VolumeMedium::open(file, input, appearance, reading);
    ASSERT_TRUE(layer) << layer.error().message;
    const auto moved = shownAt(**layer, 0.5 / 25), expected = blob(12 + kMoved / 2);
    ASSERT_EQ(moved.size(), expected.size());
    EXPECT_EQ(furthest(moved, expected) < 1e-4, one.moves) << furthest(moved, expected);
  }
  const TempFolder folder;
  const std::string file = writeBlobs(folder, true, 1, turned, {type("covariant normalize")});
  Appearance appearance;
  appearance.interpolation = Interpolation::kVelocity;
  const auto refused = VolumeMedium::open(file, input, appearance, reading);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("the vectors of 'Velocity' are normals"));
  appearance.interpolation = Interpolation::kAuto;
  EXPECT_TRUE(VolumeMedium::open(file, input, appearance, reading));
}

/// A puff that turns by 30 degrees about z from a frame to the next, within its grid or with it.
class TurningPuff {
 public:
  static constexpr int kSize = 40;
  static constexpr double kAngle = M_PI / 6, kVoxel = 0.1;

  static VolumeInfo info(int channels) {
    VolumeInfo info;
    info.x = info.y = info.z = kSize;
    info.channels = channels;
    info.frames = 2;
    info.bounds = {Vec3::Zero(), kVoxel * Vec3::Constant(kSize)};
    info.frameNumbers = {1, 2};
    info.fillDefaults();
    return info;
  }

  static Vec3 middle() { return 0.5 * kVoxel * Vec3::Constant(kSize); }

  static Mat3 turn(double angle) { return turnAbout(Vec3::UnitZ(), angle); }

  /// Density in the world when it has turned so far.
  static double density(const Vec3& world, double angle) {
    const Vec3 at = turn(angle).transpose() * (world - middle());
    return std::exp(-(at - Vec3(1, 0, 0)).squaredNorm() / 0.18);
  }

  /// @param withGrid  the grid turns, and not what is in it
  /// @param still  nothing turns but the grid
  static std::string write(const TempFolder& folder, bool withGrid, bool still) {
    std::vector<GridTarget> targets;
    for (const int channels : {1, 3}) {
      GridTarget& target = targets.emplace_back(GridTarget{info(channels), {}});
      target.info.name = channels == 1 ? "density" : "v";
      target.description.type = channels == 3 ? "vec3s" : "float";
      target.description.map = "AffineMap";
      target.description.voxelSize = {kVoxel, kVoxel, kVoxel};
      target.description.origin = {kVoxel / 2, kVoxel / 2, kVoxel / 2};
      for (int frame = 0; frame < 2; ++frame)
        target.description.matrices.push_back(matrix(withGrid ? frame * kAngle : 0));
    }
    const std::string pattern = folder / "puff_%04d.vdb";
    auto sink = createCacheSink(pattern, targets, {});
    if (!sink)
      return "";
    for (int frame = 0; frame < 2; ++frame) {
      const GridMatrix place = matrix(withGrid ? frame * kAngle : 0);
      std::vector<float> density, velocity;
      for (int z = 0; z < kSize; ++z)
        for (int y = 0; y < kSize; ++y)
          for (int x = 0; x < kSize; ++x) {
            const Vec3 world = linearOf(place) * Vec3(x, y, z) + offsetOf(place);
            density.push_back(
                static_cast<float>(TurningPuff::density(world, still ? 0 : frame * kAngle)));
            // The chord that leads to the other frame, as its paths are straight.
            const Vec3 from = world - middle();
            const Vec3 v = still        ? Vec3(Vec3::Zero())
                           : frame == 0 ? Vec3(25 * (turn(kAngle) * from - from))
                                        : Vec3(25 * (from - turn(-kAngle) * from));
            for (int c = 0; c < 3; ++c) velocity.push_back(static_cast<float>(v[c]));
          }
      const std::vector values{Bricks::fromDense(info(1), density),
                               Bricks::fromDense(info(3), velocity)};
      if (!(*sink)->writeFrame(values))
        return "";
    }
    return (*sink)->finish() ? pattern : "";
  }

  static GridMatrix matrix(double angle) {
    const Mat3 linear = turn(angle);
    return gridMatrix(kVoxel * linear,
                      middle() + linear * (0.5 * kVoxel * Vec3::Ones() - middle()));
  }
};

TEST(VolumeMotion, APuffTurnsWithItsGridOrInIt) {
  Progress progress;
  Reading reading{progress, 1 << 30};
  InputOptions input;
  input.grid = "density";
  for (const bool still : {false, true}) {
    for (const bool withGrid : {false, true}) {
      const TempFolder folder;
      const std::string file = TurningPuff::write(folder, withGrid, still);
      if (file.empty())
        GTEST_SKIP() << "built without OpenVDB";
      for (const auto how : {Interpolation::kVelocity, Interpolation::kLinear}) {
        Appearance appearance;
        appearance.interpolation = how;
        auto layer = VolumeMedium::open(file, input, appearance, reading);
        ASSERT_TRUE(layer) << layer.error().message;
        const double framePosition = (*layer)->framePositionAt(0.5 / 25);
        ASSERT_NEAR(framePosition, 0.5, 1e-6);
        const auto slice = (*layer)->sliceAt(framePosition);
        ASSERT_TRUE(slice) << slice.error().message;
        const VolumeInfo info = (*layer)->infoAt(framePosition);
        const Placement place = (*layer)->placementAt(framePosition);
        double most = 0;
        for (int z = 4; z < 36; ++z)
          for (int y = 4; y < 36; ++y)
            for (int x = 4; x < 36; ++x) {
              const Vec3 own = info.bounds.min +
                               (Vec3(x, y, z) + Vec3::Constant(0.5)).cwiseProduct(info.voxelSize());
              const Vec3 world = place.turn * own + place.offset;
              // The middle of a chord is nearer to the axis than that of the arc.
              const Vec3 from = world - TurningPuff::middle();
              const double shrunk = still ? 1 : std::cos(TurningPuff::kAngle / 2);
              const Vec3 onArc(from.x() / shrunk, from.y() / shrunk, from.z());
              const double expected =
                  how == Interpolation::kVelocity || still
                      ? TurningPuff::density(TurningPuff::middle() + onArc,
                                             still ? 0 : TurningPuff::kAngle / 2)
                      : 0.5 * (TurningPuff::density(world, 0) +
                               TurningPuff::density(world, TurningPuff::kAngle));
              most = std::max(most, std::abs((*slice)->value(x, y, z) - expected));
            }
        // Voxels of 0.1 m are interpolated where a grid is turned against the other.
        EXPECT_LT(most, 0.06) << still << withGrid << static_cast<int>(how);
      }
    }
  }
}

TEST(VolumeMotion, ALayerWithoutVelocitiesSaysSo) {
  const TempFolder folder;
  const std::string file = writeBlobs(folder, false);
  if (file.empty())
    GTEST_SKIP() << "built without OpenVDB";
  Progress progress;
  Reading reading{progress, 1 << 30};
  Appearance appearance;
  appearance.interpolation = Interpolation::kVelocity;
  const auto refused = VolumeMedium::open(file, {}, appearance, reading);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("no grid of velocities"));
  EXPECT_THAT(refused.error().message, HasSubstr("it has density"));
  appearance.interpolation = Interpolation::kAuto;
  auto layer = VolumeMedium::open(file, {}, appearance, reading);
  ASSERT_TRUE(layer) << layer.error().message;
  EXPECT_NEAR((*layer)->framePositionAt(0.5 / 25), 0.5, 1e-9);
  EXPECT_EQ((*layer)->framePositionAt(1), 1);
}

}  // namespace
}  // namespace volute
