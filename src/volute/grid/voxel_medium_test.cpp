// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/voxel_medium.hpp"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "volute/grid/bricks.hpp"
#include "volute/medium/integrate.hpp"

namespace volute {
namespace {

constexpr double kNoEnd = std::numeric_limits<double>::infinity();

/// A flame-like blob in a volume of odd sizes and oblong voxels: most bricks empty, ragged edges,
/// values 0..1.
BrickSlice blob(int channels, Basis basis, unsigned seed = 1) {
  VolumeInfo info;
  info.x = 37, info.y = 21, info.z = 50;
  info.channels = channels;
  info.bounds = {Vec3(-1, 0.5, 2), Vec3(2, 2.5, 7)};
  info.basis = basis;
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(0, 1);
  std::vector<float> values(info.frameValues());
  for (int z = 0; z < info.z; ++z) {
    for (int y = 0; y < info.y; ++y) {
      for (int x = 0; x < info.x; ++x) {
        const double distance = std::hypot((x - 20) / 8.0, (y - 12) / 6.0, (z - 22) / 14.0);
        for (int c = 0; c < channels; ++c) {
          const float value = uniform(random);
          const std::size_t voxel = (static_cast<std::size_t>(z) * info.y + y) * info.x + x;
          if (distance < 1 && value > 0.2F)
            values[voxel * channels + c] = value;
        }
      }
    }
  }
  return BrickSlice::fromDense(info, values);
}

VoxelMedium medium(BrickSlice slice, double emission, double extinction) {
  return {std::make_shared<BrickSlice>(std::move(slice)), emission, extinction};
}

/// From everywhere to everywhere, along axes, in voxel planes, from inside, and short ones.
std::vector<Segment> manySegments(const VoxelMedium& voxels, int count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-0.3, 1.3);
  const Box3 bounds = voxels.bounds();
  const Vec3 voxel = voxels.slice().bounds().size().cwiseQuotient(
      Vec3(voxels.slice().x(), voxels.slice().y(), voxels.slice().z()));
  const auto point = [&] {
    return Vec3(
        bounds.min +
        Vec3(uniform(random), uniform(random), uniform(random)).cwiseProduct(bounds.size()));
  };
  std::vector<Segment> segments;
  for (int i = 0; i < count; ++i) {
    const Vec3 from = point();
    segments.push_back({from, (point() - from).normalized(), 0, kNoEnd});
    segments.push_back({from, (point() - from).normalized(), -kNoEnd, kNoEnd});
    segments.push_back({from, (point() - from).normalized(), 0.4, 0.4 + uniform(random)});
    Vec3 onPlanes = from;  // a corner of voxels, or in half voxels; the ray runs in the planes
    for (int axis = 0; axis < 3; ++axis) {
      onPlanes[axis] =
          bounds.min[axis] +
          0.5 * voxel[axis] * std::floor((from[axis] - bounds.min[axis]) / voxel[axis]);
    }
    segments.push_back({onPlanes, Vec3::Unit(i % 3), -kNoEnd, kNoEnd});
    segments.push_back({onPlanes, -Vec3::Unit(i % 3), 0, kNoEnd});
    segments.push_back(
        {onPlanes, (Vec3::Unit(i % 3) + 1e-17 * Vec3::Unit((i + 1) % 3)), -kNoEnd, kNoEnd});
  }
  return segments;
}

struct Case {
  std::string name;
  int channels;
  Basis basis;
  double emission, extinction;
};

class VoxelMediumCases : public ::testing::TestWithParam<Case> {
 protected:
  VoxelMedium make() const {
    return medium(blob(GetParam().channels, GetParam().basis), GetParam().emission,
                  GetParam().extinction);
  }
};

/// The largest difference, as a share of the brightest reference.
double worstError(std::span<const Radiance> reference, std::span<const Radiance> other) {
  double brightest = 0;
  double worst = 0;
  for (const Radiance& light : reference) brightest = std::max(brightest, light.emitted.maxCoeff());
  for (std::size_t i = 0; i < reference.size(); ++i) {
    const double emitted = (reference[i].emitted - other[i].emitted).abs().maxCoeff() / brightest;
    const double passed = std::abs(reference[i].transmittance - other[i].transmittance);
    for (double error : {emitted, passed}) {
      if (!(error <= worst))
        worst = std::isnan(error) ? kNoEnd : error;
    }
  }
  return worst;
}

TEST_P(VoxelMediumCases, FastPathAgreesWithTheReference) {
  const VoxelMedium voxels = make();
  const auto segments = manySegments(voxels, 300);
  std::vector<Radiance> reference(segments.size());
  std::vector<Radiance> fast(segments.size());
  radianceByPieces(voxels, segments, reference);
  voxels.radiance(segments, fast);
  EXPECT_LT(worstError(reference, fast), 1e-5);
}

TEST_P(VoxelMediumCases, EveryTargetGivesTheSameBitsWhateverTheBatch) {
  const VoxelMedium voxels = make();
  const auto segments = manySegments(voxels, 50);
  std::vector<Radiance> first(segments.size());
  voxels.radiance(segments, first);
  for (std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    std::vector<Radiance> other(segments.size());
    for (std::size_t i = 0; i < segments.size(); i += 13) {
      const std::size_t count = std::min<std::size_t>(13, segments.size() - i);
      voxels.radiance(std::span(segments).subspan(i, count), std::span(other).subspan(i, count));
    }
    for (std::size_t i = 0; i < segments.size(); ++i) {
      ASSERT_TRUE((first[i].emitted == other[i].emitted).all()) << hwy::TargetName(target);
      ASSERT_EQ(first[i].transmittance, other[i].transmittance) << hwy::TargetName(target);
    }
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

TEST_P(VoxelMediumCases, PiecesAgreeWithPointsAndWithTheOpticalDepth) {
  const VoxelMedium voxels = make();
  const auto segments = manySegments(voxels, 20);
  std::vector<std::vector<Piece>> pieces(segments.size());
  std::vector<double> depths(segments.size());
  voxels.pieces(segments, pieces);
  voxels.opticalDepth(segments, depths);
  for (std::size_t i = 0; i < segments.size(); ++i) {
    double sum = 0;
    for (const Piece& piece : pieces[i]) {
      sum += pieceOpticalDepth(piece);
      // Near a plane the point may round to the other side; so only inside.
      if (piece.end - piece.begin < 1e-6)
        continue;
      for (double share : {0.1, 0.5, 0.9}) {
        const double u = share * (piece.end - piece.begin);
        const Vec3 point = segments[i].at(piece.begin + u);
        EXPECT_NEAR(piece.extinction(u), voxels.extinction(point), 1e-9);
        for (int c = 0; c < 3; ++c)
          EXPECT_NEAR(piece.emission[c](u), voxels.emission(point)[c], 1e-9);
      }
    }
    EXPECT_NEAR(sum, depths[i], 1e-11 * (1 + sum));
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, VoxelMediumCases,
    ::testing::Values(Case{"boxGrey", 1, Basis::kBox, 3, 0}, Case{"boxRgb", 3, Basis::kBox, 3, 0},
                      Case{"boxGreyAbsorbing", 1, Basis::kBox, 2, 4},
                      Case{"boxRgbAbsorbing", 3, Basis::kBox, 2, 4},
                      Case{"boxRgbDense", 3, Basis::kBox, 200, 300},
                      Case{"trilinearGrey", 1, Basis::kTrilinear, 3, 0},
                      Case{"trilinearRgb", 3, Basis::kTrilinear, 3, 0},
                      Case{"trilinearGreyAbsorbing", 1, Basis::kTrilinear, 2, 4},
                      Case{"trilinearRgbAbsorbing", 3, Basis::kTrilinear, 2, 4},
                      Case{"trilinearRgbDense", 3, Basis::kTrilinear, 200, 300}),
    [](const auto& info) { return info.param.name; });

TEST(VoxelMedium, OneVoxelIsAClosedForm) {
  VolumeInfo info;
  info.x = info.y = info.z = 1;
  info.bounds = {Vec3(0, 0, 0), Vec3(2, 3, 4)};
  const std::vector<float> value{0.5F};
  const Segment segment{Vec3(1, 1.5, -5), Vec3::UnitZ(), 0, kNoEnd};
  for (Basis basis : {Basis::kBox, Basis::kTrilinear}) {
    info.basis = basis;
    const VoxelMedium voxels = medium(BrickSlice::fromDense(info, value), 3, 0.25);
    // Box: 4 m of 0.5. Trilinear: a tent of the same area, 8 m wide.
    double depth = 0;
    voxels.opticalDepth({&segment, 1}, {&depth, 1});
    EXPECT_DOUBLE_EQ(depth, 0.25 * 0.5 * 4);
    Radiance light;
    voxels.radiance({&segment, 1}, {&light, 1});
    EXPECT_NEAR(light.transmittance, std::exp(-0.5), 1e-6);
    EXPECT_NEAR(light.emitted[2], 3 / 0.25 * (1 - std::exp(-0.5)), 1e-5);
    EXPECT_EQ(voxels.bounds().min.z(), basis == Basis::kBox ? 0 : -2);
    EXPECT_DOUBLE_EQ(voxels.extinction(Vec3(1, 1.5, 3)), basis == Basis::kBox ? 0.125 : 0.09375);
  }
}

TEST(VoxelMedium, EmptyVolumesLetAllLightThrough) {
  VolumeInfo info;
  info.x = info.y = info.z = 9;
  info.bounds = {Vec3::Zero(), Vec3::Ones()};
  for (Basis basis : {Basis::kBox, Basis::kTrilinear}) {
    info.basis = basis;
    const VoxelMedium voxels = medium(BrickSlice(info), 1, 1);
    const auto segments = manySegments(voxels, 3);
    std::vector<Radiance> light(segments.size(), Radiance{Rgb::Ones(), 0.5});
    voxels.radiance(segments, light);
    for (const Radiance& one : light) {
      EXPECT_EQ(one.emitted.maxCoeff(), 0);
      EXPECT_EQ(one.transmittance, 1);
    }
  }
}

TEST(VoxelMedium, BrokenValuesNeitherHangNorSpread) {
  VolumeInfo info;
  info.x = info.y = info.z = 16;
  info.channels = 3;
  info.bounds = {Vec3::Zero(), Vec3::Ones()};
  std::vector<float> values(info.frameValues(), 0.5F);
  values[0] = std::numeric_limits<float>::quiet_NaN();
  values[3 * 15] = std::numeric_limits<float>::infinity();
  for (Basis basis : {Basis::kBox, Basis::kTrilinear}) {
    info.basis = basis;
    const VoxelMedium voxels = medium(BrickSlice::fromDense(info, values), 1, 1);
    std::vector<Segment> segments(40, {Vec3(0.5, 0.5, -1), Vec3::UnitZ(), 0, kNoEnd});
    segments[5].origin = Vec3(0.01, 0.01, -1);
    std::vector<Radiance> light(segments.size());
    voxels.radiance(segments, light);
    EXPECT_TRUE(std::isnan(light[5].emitted[0]));
    EXPECT_TRUE(light[4].emitted.allFinite());
    EXPECT_TRUE((light[6].emitted == light[4].emitted).all());
  }
}

TEST(VoxelMedium, CountsWhatItVisits) {
  const VoxelMedium voxels = medium(blob(1, Basis::kBox), 1, 0);
  const VoxelMedium copy = voxels;
  const auto segments = manySegments(voxels, 20);
  std::vector<Radiance> light(segments.size());
  copy.radiance(segments, light);
  EXPECT_GT(voxels.counts().voxels, voxels.counts().bricksVisited);
  EXPECT_GT(voxels.counts().bricksVisited, 0u);
  EXPECT_GT(voxels.counts().bricksSkipped, 0u);
}

TEST(VoxelMedium, CoefficientsComeBack) {
  for (Basis basis : {Basis::kBox, Basis::kTrilinear}) {
    for (int channels : {1, 3}) {
      const VoxelMedium voxels = medium(blob(channels, basis), 1, 0.7);
      const auto coefficients = voxels.coefficients();
      EXPECT_EQ(voxels.withCoefficients(coefficients).coefficients(), coefficients);
    }
  }
}

/// Where a ray parallel to an axis lies between two bricks, each of them is rounded otherwise.
TEST(VoxelMedium, RaysOnFacesOfBricksLoseNothing) {
  VolumeInfo info;
  info.x = 300, info.y = 260, info.z = 411;
  info.bounds = {Vec3::Zero(), Vec3(3, 3.1, 4.11)};
  std::vector<BrickPlace> places;
  for (int i = 0; i < 27; ++i) places.push_back({20 + i % 3, 5 + i / 3 % 3, 28 + i / 9});
  const Vec3 voxel = info.bounds.size().cwiseQuotient(Vec3(info.x, info.y, info.z));
  for (const Basis basis : {Basis::kBox, Basis::kTrilinear, Basis::kCubic}) {
    info.basis = basis;
    BrickSlice slice(info, places);
    for (const BrickSlice::Entry& entry : slice.entries())
      std::fill_n(slice.brick(entry.stored), BrickSlice::kVoxels, 2.0F);
    const VoxelMedium medium(std::make_shared<BrickSlice>(std::move(slice)), 0, 1);
    for (int axis = 0; axis < 3; ++axis) {
      for (int i = 2; i < 22; ++i) {
        for (const double part : {0.0, 0.5}) {
          Vec3 at = voxel.cwiseProduct(Vec3(160 + i + part, 40 + i + part, 224 + i + part));
          at[axis] = -1;
          const Segment ray{at, Vec3::Unit(axis), 0, 100};
          double depth = 0;
          medium.opticalDepth({&ray, 1}, {&depth, 1});
          EXPECT_NEAR(depth, 48 * voxel[axis], 1e-6) << axis << " " << i << " " << part;
        }
      }
    }
  }
}

/// Tiles share bricks in the march, wherever they are in a box that no table of it could hold.
TEST(VoxelMedium, TilesFarAwayAreWhatTheirVoxelsAre) {
  constexpr int kFar = 80000;
  VolumeInfo info;
  info.x = info.y = info.z = 100000;
  info.bounds = {Vec3::Zero(), Vec3::Constant(100000)};
  Bricks bricks;
  bricks.addTile({{kFar, kFar, kFar}, 32, true, {0.01F}});
  bricks.addTile({{kFar + 32, kFar, kFar}, 8, true, {0.03F}});
  std::ranges::fill(bricks.addLeaf({{kFar - 8, kFar, kFar}}), 0.02F);
  bricks.addLeaf({{16, 16, 16}})[0] = 1;
  bricks.sort();
  for (const Basis basis : {Basis::kBox, Basis::kTrilinear, Basis::kCubic}) {
    info.basis = basis;
    const BrickSlice slice = BrickSlice::fromBricks(info, bricks);
    EXPECT_LT(slice.storedBricks(), 6U);
    EXPECT_LT(slice.bytes(), 1U << 20);
    const VoxelMedium shared(std::make_shared<BrickSlice>(slice), 1, 1),
        own(std::make_shared<BrickSlice>(slice.unshared()), 1, 1);
    std::vector<Segment> rays;
    for (int i = 0; i < 40; ++i)
      rays.push_back(
          {Vec3(kFar - 50, kFar - 3 + i, kFar + 2.5), Vec3(1, 0.1, 0.05).normalized(), 0, 1e6});
    std::vector<Radiance> a(rays.size()), b(rays.size());
    shared.radiance(rays, a), own.radiance(rays, b);
    std::vector<double> depths(rays.size());
    shared.opticalDepth(rays, depths);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      EXPECT_EQ(a[i].transmittance, b[i].transmittance);
      EXPECT_NEAR(a[i].transmittance, std::exp(-depths[i]), 1e-4);
    }
    EXPECT_GT(depths[10], 0.3);
  }
}

}  // namespace
}  // namespace volute
