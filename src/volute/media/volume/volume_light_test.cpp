// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/volume/volume_light.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "volute/grid/bricks.hpp"
#include "volute/math/phase_function.hpp"
#include "volute/math/quadrature.hpp"
#include "volute/math/rotation.hpp"
#include "volute/medium/integrate.hpp"

namespace volute {
namespace {

constexpr double kEndless = std::numeric_limits<double>::infinity();
using Field = std::function<double(const Vec3&)>;

/// A volume of n^3 voxels over -1..1 m, with the field's values at their centres [1/m].
ShadedVoxels filled(int n, const Field& field, const Field& fire = {},
                    Basis basis = Basis::kTrilinear) {
  VolumeInfo info;
  info.x = info.y = info.z = n;
  info.channels = fire ? 4 : 1;
  info.bounds = {Vec3::Constant(-1), Vec3::Constant(1)};
  info.basis = basis;
  std::vector<float> values(info.frameValues());
  for (int z = 0; z < n; ++z) {
    for (int y = 0; y < n; ++y) {
      for (int x = 0; x < n; ++x) {
        const Vec3 at = (Vec3(x, y, z) + Vec3::Constant(0.5)) * 2 / n - Vec3::Ones();
        float* out = &values[((static_cast<std::size_t>(z) * n + y) * n + x) *
                             static_cast<std::size_t>(info.channels)];
        out[0] = static_cast<float>(field(at));
        for (int c = 1; c < info.channels; ++c) out[c] = static_cast<float>(fire(at));
      }
    }
  }
  return ShadedVoxels(std::make_shared<BrickSlice>(BrickSlice::fromDense(info, values)));
}

/// A tile of 64^3 voxels of 2.5 per metre in a volume of 80^3 over -1..1 m.
std::shared_ptr<const BrickSlice> tile() {
  VolumeInfo info;
  info.x = info.y = info.z = 80;
  info.bounds = {Vec3::Constant(-1), Vec3::Constant(1)};
  info.basis = Basis::kTrilinear;
  Bricks bricks;
  bricks.addTile({{8, 8, 8}, 64, true, {2.5F, 0, 0}});
  return std::make_shared<const BrickSlice>(BrickSlice::fromBricks(info, bricks));
}

/// Billows: several soft balls, thick in the middle of each.
double billows(const Vec3& p) {
  double sum = 0;
  for (int i = 0; i < 9; ++i) {
    const Vec3 centre(0.5 * std::sin(2.4 * i), 0.5 * std::cos(1.7 * i), 0.16 * (i - 4));
    const double far = (p - centre).norm() / (0.22 + 0.04 * (i % 3));
    if (far < 1)
      sum += 9 * std::pow(1 - far * far, 2);
  }
  return sum;
}

/// In double, straight from the voxels; steps of a tenth of a voxel. It shares nothing with the
/// renderer but the values.
class BruteForce {
 public:
  BruteForce(const BrickSlice& slice, const VolumeLighting& lighting)
      : slice_(slice), lighting_(lighting), step_(2.0 / slice.x() / 5) {}

  double extinction(const Vec3& world) const {
    const Vec3 p = lighting_.place.toOwn(world);
    const int n = slice_.x();
    const Vec3 place = (p + Vec3::Ones()) * n / 2 - Vec3::Constant(0.5);
    const bool cubic = slice_.basis() == Basis::kCubic;
    const int corners = cubic ? 4 : 2;
    int base[3];
    double shares[3][4];
    for (int a = 0; a < 3; ++a) {
      const int below = static_cast<int>(std::floor(place[a]));
      base[a] = cubic ? below - 1 : below;
      for (int i = 0; i < corners; ++i) {
        const double far = std::abs(place[a] - base[a] - i);
        shares[a][i] = !cubic    ? 1 - far
                       : far < 1 ? 2 / 3.0 - far * far + far * far * far / 2
                                 : std::pow(2 - far, 3) / 6;
      }
    }
    double sum = 0;
    for (int k = 0; k < corners; ++k) {
      for (int j = 0; j < corners; ++j) {
        for (int i = 0; i < corners; ++i)
          sum += shares[2][k] * shares[1][j] * shares[0][i] *
                 slice_.value(base[0] + i, base[1] + j, base[2] + k, 0);
      }
    }
    return sum;
  }

  double depth(const Vec3& from, const Vec3& way, double length) const {
    const Segment own = lighting_.place.toOwn(Segment{from, way, 0, length});
    const Interval inside = box().intersect(own.origin, own.direction).intersect({0, length});
    double sum = 0;
    if (inside.empty())
      return 0;
    const int steps = static_cast<int>(std::ceil((inside.end - inside.begin) / step_));
    const double h = (inside.end - inside.begin) / steps;
    for (int i = 0; i < steps; ++i)
      sum += h * extinction(from + (inside.begin + (i + 0.5) * h) * way);
    return sum;
  }

  Rgb light(const Segment& ray) const {
    const Segment own = lighting_.place.toOwn(ray);
    const Interval inside = box().intersect(own.origin, own.direction);
    Rgb sum = Rgb::Zero();
    if (inside.empty())
      return sum;
    const int steps = static_cast<int>(std::ceil((inside.end - inside.begin) / step_));
    const double h = (inside.end - inside.begin) / steps;
    double passed = 1;
    for (int i = 0; i < steps && passed > 1e-5; ++i) {
      const Vec3 p = ray.at(inside.begin + (i + 0.5) * h);
      const double k = extinction(p);
      if (k == 0)
        continue;
      Rgb in = Rgb::Zero();
      for (const Lamp& lamp : lighting_.lamps) {
        const Segment to = lamp.towards(p);
        const double cosine = -to.direction.dot(-ray.direction);
        in += lamp.irradiance(p) * henyeyGreenstein(lighting_.asymmetry, cosine) *
              std::exp(-depth(p, to.direction, to.end));
      }
      sum += passed * std::exp(-k * h / 2) * k * h * lighting_.albedo * in;
      passed *= std::exp(-k * h);
    }
    return sum;
  }

 private:
  Box3 box() const {
    const double reach = 1 + (slice_.basis() == Basis::kCubic ? 3.0 : 1.0) / slice_.x();
    return {Vec3::Constant(-reach), Vec3::Constant(reach)};
  }

  const BrickSlice& slice_;
  const VolumeLighting& lighting_;
  double step_;
};

VolumeLighting sunAndPoint() {
  VolumeLighting lighting;
  lighting.albedo = Rgb::Constant(0.9);
  lighting.asymmetry = 0.3;
  Lamp sun;
  sun.kind = Lamp::Kind::kSun;
  sun.direction = Vec3(0.6, 0.3, -0.8).normalized();
  sun.intensity = Rgb(5, 4.5, 4);
  Lamp point;
  point.position = Vec3(-0.9, -1.3, 0.4);
  point.intensity = Rgb(2, 3, 6);
  lighting.lamps = {sun, point};
  return lighting;
}

/// The largest difference on eight views, of the brightest.
double worstOfEightViews(const ShadedVoxels& smoke, const AffineMap& place = {}) {
  VolumeLighting lighting = sunAndPoint();
  lighting.place = place;
  const VolumeLight light(smoke, lighting);
  const BruteForce brute(smoke.slice(), lighting);
  std::vector<double> errors;
  double brightest = 0;
  for (int view = 0; view < 8; ++view) {
    const double turn = view * std::numbers::pi / 4;
    const Vec3 eye(4 * std::cos(turn), 4 * std::sin(turn), 1.5 - 0.5 * view);
    const ShadedVoxels seen = light.seenFrom({false, eye});
    std::vector<Segment> rays;
    for (int i = 0; i < 36; ++i) {
      const Vec3 target(0.2 * (i % 6) - 0.5, 0.2 * (i / 6) - 0.5, 0.13 * (i % 5) - 0.3);
      rays.push_back({eye, (target - eye).normalized(), 0, kEndless});
    }
    std::vector<Radiance> fast(rays.size());
    AffineMedium(AnyMedium(seen), place).radiance(rays, fast);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const Rgb expected = brute.light(rays[i]);
      brightest = std::max(brightest, expected.maxCoeff());
      errors.push_back((fast[i].emitted - expected).abs().maxCoeff());
    }
  }
  EXPECT_GT(brightest, 0.1);
  return *std::ranges::max_element(errors) / brightest;
}

TEST(VolumeLight, OfATileIsKnownAtEveryFourthVoxel) {
  const ShadedVoxels plain(tile()), coarse = ShadedVoxels::withTiles(tile(), 8);
  EXPECT_LT(3 * coarse.lightPlaces().size(), 2 * plain.lightPlaces().size());
  VolumeLighting lighting;
  lighting.albedo = Rgb(0.9, 0.8, 0.7);
  lighting.asymmetry = 0.3;
  lighting.surrounding = Rgb(0.1, 0.15, 0.2);
  Lamp sun;
  sun.kind = Lamp::Kind::kSun;
  sun.direction = Vec3(0.5, 0.3, -0.8).normalized();
  sun.intensity = Rgb(3, 2.5, 2);
  lighting.lamps.push_back(sun);
  const VolumeLight::View view{.at = Vec3(2, -3, 1)};
  std::vector<Segment> rays;
  for (int i = 0; i < 400; ++i) {
    const Vec3 to(std::sin(1.7 * i), std::cos(2.3 * i), std::sin(3.1 * i + 1));
    rays.push_back({view.at, (0.9 * to - view.at).normalized(), 0, 10});
  }
  std::vector<Radiance> a(rays.size()), b(rays.size()), exact(rays.size());
  VolumeLight(plain, lighting).seenFrom(view).radiance(rays, a);
  const ShadedVoxels lit = VolumeLight(coarse, lighting).seenFrom(view);
  lit.radiance(rays, b);
  radianceByPieces(lit, rays, exact);
  double brightest = 0, squares = 0;
  for (const Radiance& one : a) brightest = std::max(brightest, one.emitted.maxCoeff());
  ASSERT_GT(brightest, 0.1);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const double off = (a[i].emitted - b[i].emitted).abs().maxCoeff();
    squares += off * off;
    EXPECT_LE(off, 2e-2 * brightest) << i;  // where the sun's way leaves by another face
    EXPECT_LE((exact[i].emitted - b[i].emitted).abs().maxCoeff(), 1e-3 * brightest) << i;
    EXPECT_NEAR(a[i].transmittance, b[i].transmittance, 1e-3) << i;
  }
  EXPECT_LE(std::sqrt(squares / static_cast<double>(rays.size())), 5e-3 * brightest);
}

TEST(VolumeLight, IsTheBruteForceMarchOnEightViews) {
  const double worst = worstOfEightViews(filled(64, billows));
  RecordProperty("worst", std::to_string(worst));
  EXPECT_LT(worst, 5e-3);
}

/// Turned by 30 degrees, sheared and stretched.
TEST(VolumeLight, IsTheBruteForceMarchInAShearedGrid) {
  Mat3 shear;
  shear = Mat3(1, 0.4, 0, 0, 1.2, 0.3, 0, 0, 0.7);
  const Mat3 turn = turnAbout(Vec3(1, 2, 3).normalized(), std::numbers::pi / 6);
  const AffineMap place(turn * shear, Vec3(0.1, -0.2, 0.3));
  for (const Basis basis : {Basis::kTrilinear, Basis::kCubic})
    EXPECT_LT(worstOfEightViews(filled(64, billows, {}, basis), place), 5e-3);
}

TEST(VolumeLight, IsTheBruteForceMarchOverTheCubicBasis) {
  const double worst = worstOfEightViews(filled(64, billows, {}, Basis::kCubic));
  RecordProperty("worst", std::to_string(worst));
  EXPECT_LT(worst, 5e-3);
}

/// A ball of even extinction K, lit by a sun: the light along a ray through its middle, along x,
/// with the sun from +z, is K albedo E phase times the integral of exp(-K (s - s0)) exp(-K d(s)),
/// with d the way from the point up to the ball's surface.
TEST(VolumeLight, AnEvenBallIsItsIntegral) {
  constexpr double kRadius = 0.8, kExtinction = 2;
  const int n = 192;
  // The rim within a voxel by its share of the voxel.
  const ShadedVoxels ball = filled(n, [&](const Vec3& p) {
    return kExtinction * std::clamp((kRadius - p.norm()) / (2.0 / n) + 0.5, 0.0, 1.0);
  });
  VolumeLighting lighting;
  lighting.albedo = Rgb::Constant(0.9);
  lighting.asymmetry = 0.3;
  Lamp sun;
  sun.kind = Lamp::Kind::kSun;
  sun.direction = -Vec3::UnitZ();
  sun.intensity = Rgb::Constant(3);
  lighting.lamps = {sun};
  const VolumeLight light(ball, lighting);
  const ShadedVoxels seen = light.seenFrom({true, Vec3::UnitX()});
  double brightest = 0, worst = 0;
  for (const double height : {-0.6, -0.3, 0.0, 0.2, 0.5, 0.7}) {
    const double half = std::sqrt(kRadius * kRadius - height * height);
    double sum = 0;
    const int steps = 4000;
    for (int i = 0; i < steps; ++i) {
      const double s = -half + 2 * half * (i + 0.5) / steps;
      const double up = std::sqrt(kRadius * kRadius - s * s) - height;
      sum += 2 * half / steps * std::exp(-kExtinction * (s + half)) * std::exp(-kExtinction * up);
    }
    const double expected = kExtinction * 0.9 * 3 * henyeyGreenstein(0.3, 0) * sum;
    const Segment ray{Vec3(-3, 0, height), Vec3::UnitX(), 0, kEndless};
    std::vector<Radiance> found(1);
    seen.radiance(std::span(&ray, 1), found);
    brightest = std::max(brightest, expected);
    worst = std::max(worst, std::abs(found[0].emitted[1] - expected));
  }
  RecordProperty("worst", std::to_string(worst / brightest));
  EXPECT_LT(worst / brightest, 1e-3);
}

TEST(VolumeLight, AnEvenSurroundingIsTheShareThatArrives) {
  // In the middle of a ball, exp(-K R) arrives from everywhere.
  constexpr double kRadius = 0.7, kExtinction = 1.5;
  const ShadedVoxels ball = filled(64, [&](const Vec3& p) {
    return kExtinction * std::clamp((kRadius - p.norm()) * 32 + 0.5, 0.0, 1.0);
  });
  VolumeLighting lighting;
  lighting.albedo = Rgb(0.9, 0.5, 0.1);
  lighting.surrounding = Rgb(1, 2, 3);
  const VolumeLight light(ball, lighting);
  const Rgb sent = light.seen().emission(Vec3::Constant(1e-3)) / kExtinction;
  const Rgb expected = lighting.albedo * lighting.surrounding * std::exp(-kExtinction * kRadius);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(sent[c] / expected[c], 1, 0.01);
}

/// Light of an even surrounding along rays, against 200 directions from each of many places.
double worstUnderASky(const ShadedVoxels& smoke, const AffineMap& place) {
  VolumeLighting lighting;
  lighting.albedo = Rgb::Ones();
  lighting.surrounding = Rgb::Ones();
  lighting.place = place;
  const AffineMedium thick(AnyMedium(smoke.absorption()), place);
  const AffineMedium lit(AnyMedium(VolumeLight(smoke, lighting).seen()), place);
  const auto arrivingAt = [&](const Vec3& point) {
    constexpr int kWays = 400;
    std::vector<Segment> ways;
    for (int i = 0; i < kWays; ++i) {  // a spiral
      const double up = 1 - (2 * i + 1.0) / kWays, aside = std::sqrt(1 - up * up);
      ways.push_back(
          {point, Vec3(aside * std::cos(2.4 * i), aside * std::sin(2.4 * i), up), 0, kEndless});
    }
    std::vector<double> depths(ways.size());
    thick.opticalDepth(ways, depths);
    double sum = 0;
    for (const double depth : depths) sum += std::exp(-depth);
    return sum / kWays;
  };
  double brightest = 0, worst = 0;
  for (int r = 0; r < 24; ++r) {
    const Vec3 target = place.toWorld(Vec3(0.2 * (r % 6) - 0.5, 0.1, 0.25 * (r / 6) - 0.35));
    const Vec3 eye = place.toWorld(Vec3(1, -4, 0.3));
    const Segment ray{eye, (target - eye).normalized(), 0, kEndless};
    constexpr int kSteps = 200;
    std::vector<Segment> steps(kSteps, ray);
    for (int i = 0; i < kSteps; ++i) {
      steps[static_cast<std::size_t>(i)].begin = 2 + 4.0 * i / kSteps;
      steps[static_cast<std::size_t>(i)].end = 2 + 4.0 * (i + 1) / kSteps;
    }
    std::vector<double> depths(kSteps);
    thick.opticalDepth(steps, depths);
    double expected = 0, passed = 1;
    for (std::size_t i = 0; i < kSteps; ++i) {
      if (depths[i] > 0 && passed > 1e-4)
        expected += passed * -std::expm1(-depths[i]) *
                    arrivingAt(ray.at(0.5 * (steps[i].begin + steps[i].end)));
      passed *= std::exp(-depths[i]);
    }
    Radiance found;
    lit.radiance({&ray, 1}, {&found, 1});
    brightest = std::max(brightest, expected);
    worst = std::max(worst, std::abs(found.emitted[1] - expected));
  }
  return worst / brightest;
}

TEST(VolumeLight, AnEvenSurroundingIsTheBruteForceMarch) {
  for (const int n : {48, 96}) EXPECT_LT(worstUnderASky(filled(n, billows), {}), 1e-2);
  // At every fourth voxel, from fewer directions.
  EXPECT_LT(worstUnderASky(filled(264, billows), {}), 2.5e-2);
  Mat3 shear = Mat3::Identity();
  shear(0, 1) = 0.4;  // no fan: it measures lengths in the volume's own space
  EXPECT_LT(worstUnderASky(filled(32, billows), AffineMap(shear, Vec3::Zero())), 4e-2);
}

TEST(VolumeLight, FireLightsTheSmokeAroundIt) {
  // A small bright ball in thin smoke; far away it is a point of its power.
  const auto fire = [](const Vec3& p) { return (p - Vec3(-0.6, 0, 0)).norm() < 0.15 ? 10.0 : 0.0; };
  const ShadedVoxels smoke = filled(64, [](const Vec3&) { return 0.2; }, fire);
  double power = 0;
  for (const Lamp& lamp : VolumeLight::lampsOf(smoke.slice(), {}, 1, 1000))
    power += lamp.intensity[1];
  const double volume = 4 / 3.0 * std::numbers::pi * std::pow(0.15, 3);
  EXPECT_NEAR(power, 10 * volume, 0.05 * 10 * volume);
  EXPECT_EQ(VolumeLight::lampsOf(smoke.slice(), {}, 1, 1).size(), 1U);
  VolumeLighting lighting;
  lighting.albedo = Rgb::Ones();
  const VolumeLight light(smoke, lighting);
  const Vec3 there(0.6, 0.2, 0);
  const double far = (there - Vec3(-0.6, 0, 0)).norm();
  const double expected = power / (far * far) / (4 * std::numbers::pi) * std::exp(-0.2 * far) * 0.2;
  EXPECT_NEAR(light.seen().emission(there)[1] / expected, 1, 0.03);
  lighting.ownFire = false;
  EXPECT_EQ(VolumeLight(smoke, lighting).seen().emission(there)[1], 0);
}

TEST(VolumeLight, MoreLampsAreAsIfTheyHadBeenThere) {
  const ShadedVoxels smoke = filled(32, billows);
  const VolumeLighting both = sunAndPoint();
  VolumeLighting sun = both;
  sun.lamps.pop_back();
  const VolumeLight light(smoke, sun);
  const auto more = light.withLamps({&both.lamps[1], 1});
  EXPECT_EQ(more, light.withLamps({&both.lamps[1], 1}));
  const ShadedVoxels expected = VolumeLight(smoke, both).seen(), found = more->seen();
  for (int i = 0; i < 20; ++i) {
    const Vec3 p(0.08 * i - 0.8, 0.1, 0.05 * i - 0.5);
    EXPECT_TRUE((expected.emission(p) == found.emission(p)).all());
  }
  EXPECT_NE(more, light.withLamps({}));
}

/// A box of opaque walls.
TriangleScene boxOf(const Vec3& low, const Vec3& high) {
  std::vector<Triangle> triangles;
  const auto corner = [&](int i) {
    return Vec3(i & 1 ? high.x() : low.x(), i & 2 ? high.y() : low.y(), i & 4 ? high.z() : low.z());
  };
  for (const auto& [a, b, c, d] :
       {std::array{0, 1, 3, 2}, std::array{4, 5, 7, 6}, std::array{0, 1, 5, 4},
        std::array{2, 3, 7, 6}, std::array{0, 2, 6, 4}, std::array{1, 3, 7, 5}}) {
    triangles.push_back({{corner(a), corner(b), corner(c)}});
    triangles.push_back({{corner(a), corner(c), corner(d)}});
  }
  return TriangleScene::build(std::move(triangles)).value();
}

/// A lamp in even smoke of voxels of a quarter of a metre, and a wall of a tenth.
VolumeLighting besideAWall(double lamp, double wall) {
  VolumeLighting lighting;
  lighting.albedo = Rgb::Constant(0.8);
  Lamp point;
  point.position = Vec3(lamp, 0.03, 0.02);
  lighting.lamps = {point};
  lighting.surfaces = boxOf(Vec3(wall, -3, -3), Vec3(wall + 0.1, 3, 3));
  return lighting;
}

double even(const Vec3&) {
  return 0.01;
}

TEST(VolumeLight, ALampIsAsStrongWhereverInItsVoxelItIs) {
  const auto light = [](const Vec3& place, double radius) {
    VolumeLighting lighting;
    lighting.albedo = Rgb::Constant(1);
    lighting.lamps.resize(1);
    lighting.lamps[0].position = place, lighting.lamps[0].radius = radius;
    const ShadedVoxels seen =
        VolumeLight(filled(16, [](const Vec3&) { return 1e-4; }), lighting).seen();
    double sum = 0;
    constexpr int kSteps = 64;
    for (int i = 0; i < kSteps * kSteps * kSteps; ++i) {
      const Vec3 at(i % kSteps + 0.5, i / kSteps % kSteps + 0.5, i / kSteps / kSteps + 0.5);
      sum += seen.emission(at * 2 / kSteps - Vec3::Ones())[0];
    }
    return sum;
  };
  // The integral of 1 / r2 does not change by so little.
  const double centre = light(Vec3(0.0625, 0.0625, 0.0625), 0.01);
  EXPECT_NEAR(light(Vec3(0, 0, 0), 0.01) / centre, 1, 0.02);
  EXPECT_NEAR(light(Vec3(0, 0.0625, 0.0625), 0.01) / centre, 1, 0.02);
  EXPECT_NEAR(light(Vec3(0.03, 0.095, 0.05), 0.01) / centre, 1, 0.02);
  EXPECT_NEAR(light(Vec3(0.0625, 0.0625, 0.0625), 0.15) / centre, 1, 0.1);
}

TEST(VolumeLight, WhatBlocksALampKeepsItsLight) {
  VolumeLighting lighting;
  lighting.albedo = Rgb::Constant(0.8);
  Lamp sun;
  sun.kind = Lamp::Kind::kSun;
  sun.direction = -Vec3::UnitX();
  lighting.lamps = {sun};
  lighting.surfaces = boxOf(Vec3(-0.01, -3, -3), Vec3(0.01, 3, 3));
  const VolumeLight light(filled(32, billows), lighting);
  const ShadedVoxels seen = light.seen();
  EXPECT_EQ(seen.emission(Vec3(-0.3, 0.1, 0)).sum(), 0);
  EXPECT_GT(seen.emission(Vec3(0.3, 0.1, 0)).sum(), 0);
}

TEST(VolumeLight, NoLightPassesAWallThatIsThinnerThanAVoxel) {
  struct Case {
    double lamp, wall;
  };

  // In the wall, where there is a voxel's centre; behind it, of which one face holds centres.
  const std::array cases{Case{0.125, 0.075}, Case{0.8, 0.075}, Case{0.8, 0.2}, Case{0.8, 0.125}};
  for (const Basis basis : {Basis::kTrilinear, Basis::kCubic}) {
    for (const auto& [lamp, wall] : cases) {
      SCOPED_TRACE(testing::Message()
                   << "lamp " << lamp << " wall " << wall << " basis " << static_cast<int>(basis));
      const VolumeLight light(filled(8, even, {}, basis), besideAWall(lamp, wall));
      light.seenFrom({false, Vec3(4, 0.5, 0.3)});  // leaves nothing behind for the views below
      for (const VolumeView& view :
           {VolumeView{false, Vec3(-4, 0.5, 0.3)}, VolumeView{true, Vec3::UnitX()}}) {
        const ShadedVoxels seen = light.seenFrom(view);
        for (int i = 0; i < 49; ++i) {
          for (const double before : {0.001, 0.05, 0.12, 0.3}) {
            const Vec3 at(wall - before, 0.1 * (i % 7) - 0.3, 0.1 * (i / 7) - 0.3);
            EXPECT_EQ(seen.emission(at).sum(), 0) << at.x() << ' ' << at.y() << ' ' << at.z();
          }
        }
      }
    }
  }
}

TEST(VolumeLight, SmokeBeforeALitWallIsNoDarkerThanWithoutTheWall) {
  for (const Basis basis : {Basis::kTrilinear, Basis::kCubic}) {
    for (const double wall : {0.075, 0.2, 0.0}) {
      const VolumeLighting lighting = besideAWall(0.9, wall);
      const VolumeLight light(filled(16, even, {}, basis), lighting);
      VolumeLighting open = lighting;
      open.surfaces = {};
      const VolumeLight without(filled(16, even, {}, basis), open);
      const VolumeView view{false, Vec3(0.8, 0.2, 0.1)};
      const ShadedVoxels seen = light.seenFrom(view), expected = without.seenFrom(view);
      for (const double before : {0.001, 0.05, 0.1}) {
        const Vec3 at(wall + 0.1 + before, 0.2, 0.1);
        EXPECT_NEAR(seen.emission(at).sum() / expected.emission(at).sum(), 1, 0.05) << at.x();
      }
    }
  }
}

TEST(VolumeLight, ALampLightsASolidFaceWithoutStripes) {
  // 50 optical depths a voxel. The light before a face is that of the lamp's distance alone.
  constexpr int kSide = 40;
  const double voxel = 2.0 / kSide;
  const ShadedVoxels box =
      filled(kSide, [](const Vec3& p) { return p.cwiseAbs().maxCoeff() < 0.9 ? 1000.0 : 0.0; });
  VolumeLighting lighting;
  lighting.albedo = Rgb::Ones();
  Lamp lamp;
  lamp.kind = Lamp::Kind::kSpot;
  lamp.position = Vec3(1, -3, 2);
  lamp.intensity = Rgb::Constant(5);
  lamp.coneCosine = -1;
  lighting.lamps = {lamp};
  const ShadedVoxels lit = VolumeLight(box, lighting).seen();
  for (int k = 4; k < kSide - 4; ++k) {
    for (int i = 4; i < kSide - 4; ++i) {
      const Vec3 before(-1 + (i + 0.5) * voxel, -0.9 - 0.5 * voxel, -1 + (k + 0.5) * voxel);
      const Vec3 at = before + Vec3(0, 1e-3 * voxel, 0);  // where there is something to be lit
      const double light = lit.emission(at)[0] / lit.extinction(at);
      const double exact = lamp.irradiance(before)[0] / (4 * std::numbers::pi);
      EXPECT_NEAR(light / exact, 1, 0.02) << i << ' ' << k;
    }
  }
}

}  // namespace
}  // namespace volute
