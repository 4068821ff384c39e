// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/volume/light_fan.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <random>

#include "volute/grid/voxel_medium.hpp"
#include "volute/media/volume/light_fan_rows.hpp"

namespace volute {
namespace {

/// A volume of voxels that are no cubes, over trilinear values.
std::shared_ptr<const BrickSlice> fanVolume(const std::function<float(const Vec3&)>& value) {
  VolumeInfo info;
  info.x = 22, info.y = 17, info.z = 30;
  info.bounds = {Vec3(-1, 2, 0), Vec3(1.2, 3.36, 3.3)};
  info.basis = Basis::kTrilinear;
  std::vector<float> values;
  for (int z = 0; z < info.z; ++z) {
    for (int y = 0; y < info.y; ++y) {
      for (int x = 0; x < info.x; ++x)
        values.push_back(value(Vec3((x + 0.5) / info.x, (y + 0.5) / info.y, (z + 0.5) / info.z)));
    }
  }
  return std::make_shared<BrickSlice>(BrickSlice::fromDense(info, values));
}

std::vector<std::array<std::int32_t, 3>> centresOf(const BrickSlice& slice) {
  std::vector<std::array<std::int32_t, 3>> places;
  for (int z = -1; z <= slice.z(); ++z) {
    for (int y = -1; y <= slice.y(); ++y) {
      for (int x = -1; x <= slice.x(); ++x) places.push_back({x, y, z});
    }
  }
  return places;
}

struct FanError {
  double largest = 0, mean = 0;
};

/// What arrives from a lamp; of a sun also as what is beyond the points for one from the other
/// side.
std::vector<std::vector<float>> foundBy(const LightFan& fan, const Lamp& lamp, std::size_t points) {
  std::vector<std::vector<float>> found(1, std::vector<float>(points));
  EXPECT_TRUE(fan.transmittances(lamp, found[0]));
  if (lamp.kind == Lamp::Kind::kSun) {
    Lamp opposite = lamp;
    opposite.direction = -lamp.direction;
    std::vector<float> towards(points);
    found.emplace_back(points);
    EXPECT_TRUE(fan.transmittances(opposite, towards, found[1]));
  }
  return found;
}

/// Against one exact ray for each centre.
FanError fanError(const std::shared_ptr<const BrickSlice>& slice, const Lamp& lamp) {
  const VoxelMedium medium(slice, 0, 1);
  const auto points = centresOf(*slice);
  const auto found = foundBy(LightFan(*slice, points), lamp, points.size());
  const Vec3 voxel = slice->bounds().size().cwiseQuotient(Vec3(slice->x(), slice->y(), slice->z()));
  std::vector<Segment> ways;
  for (const auto& [x, y, z] : points) {
    ways.push_back(
        lamp.towards(slice->bounds().min + voxel.cwiseProduct(Vec3(x + 0.5, y + 0.5, z + 0.5))));
  }
  std::vector<double> depths(points.size());
  medium.opticalDepth(ways, depths);
  FanError error;
  for (const std::vector<float>& one : found) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double off = std::abs(static_cast<double>(one[i]) - std::exp(-depths[i]));
      error.largest = std::max(error.largest, off);
      error.mean += off / static_cast<double>(points.size() * found.size());
    }
  }
  return error;
}

Lamp sunFrom(const Vec3& towards) {
  Lamp lamp;
  lamp.kind = Lamp::Kind::kSun;
  lamp.direction = -towards.normalized();
  return lamp;
}

Lamp pointAt(const Vec3& place) {
  Lamp lamp;
  lamp.position = place;
  return lamp;
}

float smooth(const Vec3& p) {
  const Vec3 from = p - Vec3(0.45, 0.55, 0.5);
  return static_cast<float>(4 * std::exp(-30 * from.squaredNorm()));
}

const Vec3 kWays[] = {Vec3(0, 0, 1),    Vec3(0, 0, -1),     Vec3(1, 0, 0),       Vec3(0, -1, 0),
                      Vec3(1, 2, 3),    Vec3(-3, 0.2, 1),   Vec3(0.1, -2, -0.5), Vec3(1, 1, 1),
                      Vec3(-1, 1, 0.3), Vec3(0.5, -3, 2.9), Vec3(-0.2, -0.1, -4)};

TEST(LightFan, RowsOfRaysHaveTheirExactMeans) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> uniform(0, 1);
  FanPlanes planes(9, 30);
  const auto at = [&](int side, double b, double c) {
    const auto value = [&](int row, int column) {
      const int place = (row + FanPlanes::kPad) * planes.width + column + FanPlanes::kPad;
      return static_cast<double>(planes.values[static_cast<std::size_t>(2 * place + side)]);
    };
    const int row = static_cast<int>(std::floor(b)), column = static_cast<int>(std::floor(c));
    const double u = b - row, v = c - column;
    return (1 - u) * ((1 - v) * value(row, column) + v * value(row, column + 1)) +
           u * ((1 - v) * value(row + 1, column) + v * value(row + 1, column + 1));
  };
  for (int row = 0; row < planes.rows; ++row) {
    for (int column = 0; column < planes.columns; ++column) {
      const int place = (row + FanPlanes::kPad) * planes.width + column + FanPlanes::kPad;
      for (int side = 0; side < 2; ++side)
        planes.values[static_cast<std::size_t>(2 * place + side)] = uniform(random);
    }
  }
  constexpr std::size_t kRays = 3 * kFanRays;
  for (const FanRow& row : {FanRow{2.3F, 0.9F, -4, 0.8F, -0.6F, 0.03F, 0},
                            FanRow{6.9F, -0.4F, 1.2F, 0.5F, 0.7F, -0.01F, 0.25F},
                            FanRow{-0.5F, 0, 3, 0.25F, 0, 0, 0}}) {
    alignas(64) float depths[kRays], lengths[kRays];
    std::fill_n(depths, kRays, 1.0F);
    for (std::size_t j = 0; j < kRays; ++j) lengths[j] = 1 + 0.1F * static_cast<float>(j);
    addFanRow(planes, row, kRays, 0.5F, lengths, depths);
    for (std::size_t j = 0; j < kRays; ++j) {
      const double c = row.c + static_cast<double>(j) * row.cStep;
      const double dc = row.dc + static_cast<double>(j) * row.dcStep;
      double mean = 0;
      constexpr int kSteps = 2000;
      for (int i = 0; i < kSteps; ++i) {
        const double t = (i + 0.5) / kSteps, z = row.z + t * (1 - row.z);
        const double placeC = c + t * dc;
        if (placeC <= -1 || placeC >= planes.columns)
          continue;
        const double b = row.b + t * row.db;
        mean += ((1 - z) * at(0, b, placeC) + z * at(1, b, placeC)) / kSteps;
      }
      EXPECT_NEAR(depths[j], 1 + 0.5 * lengths[j] * mean, 1e-5 * lengths[j] + 1e-5) << j;
    }
  }
}

TEST(LightFan, OfSunsIsOneRayForEachCentre) {
  const auto slice = fanVolume(smooth);
  for (const Vec3& way : kWays) {
    const FanError error = fanError(slice, sunFrom(way));
    EXPECT_LT(error.largest, 2.5e-2) << way;
    EXPECT_LT(error.mean, 1e-3) << way;
  }
}

TEST(LightFan, OfLampsIsOneRayForEachCentre) {
  const auto slice = fanVolume(smooth);
  const Vec3 middle = slice->bounds().min + 0.5 * slice->bounds().size();
  for (const Vec3& way : kWays) {
    for (const double far : {0.02, 0.9, 2.4, 30.0}) {
      const FanError error = fanError(slice, pointAt(middle + far * way.normalized()));
      EXPECT_LT(error.largest, 2.5e-2) << way << " " << far;
      EXPECT_LT(error.mean, 1e-3) << way << " " << far;
    }
  }
}

TEST(LightFan, IsExactAlongAxes) {
  std::mt19937 random(4);
  std::uniform_real_distribution<float> uniform(-1, 1);
  const auto slice = fanVolume([&](const Vec3&) { return std::max(0.0F, uniform(random)); });
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0})
      EXPECT_LT(fanError(slice, sunFrom(sign * Vec3::Unit(axis))).largest, 1e-5) << axis << sign;
  }
}

/// Noise has no values between rays; what is found stays near what is there.
TEST(LightFan, StaysNearInNoise) {
  std::mt19937 random(4);
  std::uniform_real_distribution<float> uniform(-1, 1);
  const auto slice = fanVolume([&](const Vec3&) { return std::max(0.0F, uniform(random)); });
  for (const Vec3& way : kWays) EXPECT_LT(fanError(slice, sunFrom(way)).mean, 2.5e-2);
  EXPECT_LT(fanError(slice, pointAt(Vec3(0, 2.5, 1.4))).mean, 2.5e-2);
}

/// Puffs in a large box, of which most rays touch nothing.
TEST(LightFan, OfSunsInASparseVolumeIsOneRayForEachPoint) {
  VolumeInfo info;
  info.x = 300, info.y = 260, info.z = 411;
  info.bounds = {Vec3(0, 0, 0), Vec3(3, 3.1, 4.11)};
  info.basis = Basis::kTrilinear;
  std::vector<BrickPlace> bricks;
  std::vector<std::array<std::int32_t, 3>> places;
  const BrickPlace corners[] = {{3, 30, 2}, {20, 5, 28}, {34, 29, 48}};
  for (const BrickPlace& corner : corners) {
    for (int i = 0; i < 27; ++i)
      bricks.push_back({corner[0] + i % 3, corner[1] + i / 3 % 3, corner[2] + i / 9});
    for (int i = 0; i < 13 * 13 * 13; ++i) {
      places.push_back({8 * corner[0] - 1 + 2 * (i % 13), 8 * corner[1] - 1 + 2 * (i / 13 % 13),
                        8 * corner[2] - 1 + 2 * (i / 169)});
    }
  }
  std::ranges::sort(bricks, isBefore);
  auto slice = std::make_shared<BrickSlice>(info, bricks);
  for (const BrickSlice::Entry& entry : slice->entries()) {
    const BrickPlace& corner = corners[entry.place[2] < 10 ? 0 : entry.place[2] < 40 ? 1 : 2];
    for (int i = 0; i < BrickSlice::kVoxels; ++i) {
      const int at[3] = {entry.place[0] * 8 + i % 8, entry.place[1] * 8 + i / 8 % 8,
                         entry.place[2] * 8 + i / 64};
      if (at[0] < info.x && at[1] < info.y && at[2] < info.z)
        slice->brick(entry.stored)[i] = 2 + std::sin(0.3F * at[0]) + std::cos(0.4F * at[1]);
      for (std::size_t axis = 0; axis < 3; ++axis)  // fades towards the puff's faces
        slice->brick(entry.stored)[i] *= std::sin(0.1309F * (at[axis] - 8 * corner[axis] + 0.5F));
    }
  }
  const VoxelMedium medium(slice, 0, 1);
  const Vec3 voxel = slice->bounds().size().cwiseQuotient(Vec3(info.x, info.y, info.z));
  for (const Vec3& way : kWays) {
    const Lamp sun = sunFrom(way);
    const auto found = foundBy(LightFan(*slice, places), sun, places.size());
    std::vector<Segment> ways;
    for (const auto& [x, y, z] : places)
      ways.push_back(sun.towards(voxel.cwiseProduct(Vec3(x + 0.5, y + 0.5, z + 0.5))));
    std::vector<double> depths(places.size());
    medium.opticalDepth(ways, depths);
    for (const std::vector<float>& one : found) {
      double mean = 0;
      for (std::size_t i = 0; i < places.size(); ++i) {
        const double off = std::abs(static_cast<double>(one[i]) - std::exp(-depths[i]));
        EXPECT_LT(off, 0.03) << way;
        mean += off / static_cast<double>(places.size());
      }
      EXPECT_LT(mean, 1e-3) << way;
    }
  }
}

TEST(LightFan, NothingTakesNothing) {
  const auto slice = fanVolume([](const Vec3&) { return 0.0F; });
  EXPECT_EQ(fanError(slice, sunFrom(Vec3(1, 2, 3))).largest, 0);
  EXPECT_EQ(fanError(slice, pointAt(Vec3(0, 2.5, 1.4))).largest, 0);
}

}  // namespace
}  // namespace volute
