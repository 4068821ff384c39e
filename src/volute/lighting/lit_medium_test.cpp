// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/lighting/lit_medium.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "volute/math/phase_function.hpp"
#include "volute/math/quadrature.hpp"
#include "volute/medium/conformance.hpp"

namespace volute {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kEven = 0.05;  ///< extinction [1/m]

/// Even extinction in a box, which sends nothing.
struct EvenBox {
  Box3 box{Vec3::Constant(-40), Vec3::Constant(40)};

  Box3 bounds() const { return box; }

  double extinction(const Vec3& point) const { return box.contains(point) ? kEven : 0; }

  Rgb emission(const Vec3&) const { return Rgb::Zero(); }

  Interval inside(const Segment& segment) const {
    return box.intersect(segment.origin, segment.direction).intersect({segment.begin, segment.end});
  }

  void opticalDepth(std::span<const Segment> segments, std::span<double> depths) const {
    for (std::size_t i = 0; i < segments.size(); ++i) {
      const Interval part = inside(segments[i]);
      depths[i] = part.empty() ? 0 : kEven * (part.end - part.begin);
    }
  }

  void pieces(std::span<const Segment> segments, std::span<std::vector<Piece>> pieces) const {
    for (std::size_t i = 0; i < segments.size(); ++i) {
      pieces[i].clear();
      const Interval part = inside(segments[i]);
      if (!part.empty())
        pieces[i].push_back({part.begin, part.end, Cubic{{kEven, 0, 0, 0}}, {}, 0});
    }
  }
};

Lamp lampAt(const Vec3& place, const Rgb& intensity = Rgb(100, 50, 20)) {
  Lamp lamp;
  lamp.position = place;
  lamp.intensity = intensity;
  lamp.radius = 0.5;
  return lamp;
}

LitMedium lit(std::span<const Lamp> lamps, const Scattering& scattering,
              const std::vector<AnyMedium>& between = {}, const ShadowsOn& shadows = {}) {
  std::vector<AnyMedium> media{AnyMedium(EvenBox())};
  media.insert(media.end(), between.begin(), between.end());
  std::vector<LightField> fields;
  for (const Lamp& lamp : lamps) fields.emplace_back(lamp, media, EvenBox().box);
  return {AnyMedium(EvenBox()),
          std::move(fields),
          {scattering, {Vec3::Constant(-41), Vec3::Constant(41)}, 4, shadows}};
}

TEST(LitMedium, SendsWhatArrivesAtAPoint) {
  const Lamp lamp = lampAt(Vec3(1, 2, 3));
  const LitMedium medium = lit({&lamp, 1}, {.albedo = Rgb(0.9, 0.8, 0.7)});
  for (const Vec3& away : {Vec3(3, 1, -2), Vec3(-9, 4, 7), Vec3(0.2, -20, 1)}) {
    const double far = away.norm();
    const Rgb expected = kEven * Rgb(0.9, 0.8, 0.7) * lamp.intensity / (far * far) *
                         std::exp(-kEven * far) / (4 * kPi);
    const Rgb found = medium.emission(lamp.position + away);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c] / expected[c], 1, 1e-2);
  }
}

/// All light that a ball around the lamp scatters is what it does not let out.
TEST(LitMedium, ScattersTheLampsPower) {
  const Lamp lamp = lampAt(Vec3::Zero());
  const LitMedium medium = lit({&lamp, 1}, {});
  constexpr double kRadius = 30;
  double sum = 0;
  for (int i = 0; i < 60; ++i) {  // even shells
    const double far = kRadius * (i + 0.5) / 60;
    const Rgb sent = medium.emission(far * Vec3(1, 1, 1).normalized());
    const double reached = std::max(far, lamp.radius) / far;
    sum += 4 * kPi * sent[0] * reached * reached * 4 * kPi * far * far * kRadius / 60;
  }
  const double expected = 4 * kPi * 100 * -std::expm1(-kEven * kRadius);
  EXPECT_NEAR(sum / expected, 1, 1e-2);
}

/// From far away, close by, through the lamp, and ending before it.
std::vector<Segment> raysAround(const Vec3& place) {
  std::vector<Segment> rays;
  for (int i = 0; i < 60; ++i) {
    const Vec3 eye(-60, 12.0 * std::sin(i), 9.0 * std::cos(1.3 * i));
    const double miss = i % 4 == 0 ? 0.3 : 1.5 * (i % 9);
    const Vec3 target = place + miss * Vec3(0, std::sin(2.0 * i), std::cos(2.0 * i));
    rays.push_back({eye, (target - eye).normalized(), 0, i % 5 == 0 ? 55.0 : 200.0});
  }
  return rays;
}

TEST(LitMedium, FastPathIsTheIntegralOfItsFormula) {
  const Lamp lamp = lampAt(Vec3(1, 2, 3));
  const LitMedium medium = lit({&lamp, 1}, {.albedo = Rgb::Constant(0.9), .asymmetry = 0.6});
  const auto rays = raysAround(lamp.position);
  std::vector<Radiance> fast(rays.size());
  medium.radiance(rays, fast);
  std::vector<double> expected;
  for (const Segment& ray : rays) {
    const Interval in = EvenBox().inside(ray);
    expected.push_back(adaptiveIntegral(
        [&](double s) {
          const Vec3 away = ray.at(s) - lamp.position;
          const double far = away.norm(), near = std::max(far, lamp.radius);
          return kEven * 0.9 * 100 / (near * near) * std::exp(-kEven * (far + s - in.begin)) *
                 henyeyGreenstein(0.6, -away.dot(ray.direction) / far);
        },
        in.begin, in.end, 1e-6));
  }
  const double brightest = *std::ranges::max_element(expected);
  EXPECT_GT(brightest, 0.1);
  for (std::size_t i = 0; i < rays.size(); ++i)
    EXPECT_NEAR(fast[i].emitted[0], expected[i], 5e-3 * brightest) << i;
}

TEST(LitMedium, FastPathFollowsTheSoftRimOfACone) {
  Lamp lamp = lampAt(Vec3(1, 2, 3));
  lamp.coneCosine = 0.9, lamp.edge = 0.1, lamp.direction = Vec3(0.3, 0.4, -1).normalized();
  const LitMedium medium = lit({&lamp, 1}, {.albedo = Rgb::Constant(0.9)});
  auto rays = raysAround(lamp.position + 6 * lamp.direction);
  std::vector<Radiance> fast(rays.size());
  medium.radiance(rays, fast);
  std::vector<double> expected;
  for (const Segment& ray : rays) {
    const Interval in = EvenBox().inside(ray);
    double sum = 0;
    constexpr int kSteps = 20000;
    for (int k = 0; k < kSteps; ++k) {
      const double s = in.begin + in.length() * (k + 0.5) / kSteps;
      const double far = (ray.at(s) - lamp.position).norm();
      sum += kEven * 0.9 / (4 * kPi) * lamp.irradiance(ray.at(s))[0] *
             std::exp(-kEven * (far + s - in.begin)) * in.length() / kSteps;
    }
    expected.push_back(sum);
  }
  const double brightest = *std::ranges::max_element(expected);
  for (std::size_t i = 0; i < rays.size(); ++i)
    EXPECT_NEAR(fast[i].emitted[0], expected[i], 5e-3 * brightest) << i;
}

TEST(LitMedium, FastPathIsThatOfItsPieces) {
  const Lamp lamps[] = {lampAt(Vec3(0, 0, 0)), lampAt(Vec3(1, 0.5, 2), Rgb(30, 30, 60)),
                        lampAt(Vec3(-1, 1, 3))};
  const LitMedium medium = lit(lamps, {.asymmetry = 0.3});
  auto rays = raysAround(Vec3(0, 0, 1));
  for (const Segment& ray : raysAround(Vec3(0, 25, -20))) rays.push_back(ray);
  std::vector<Radiance> fast(rays.size()), exact(rays.size());
  medium.radiance(rays, fast);
  radianceByPieces(medium, rays, exact);
  double brightest = 0;
  for (const Radiance& one : exact) brightest = std::max(brightest, one.emitted.maxCoeff());
  for (std::size_t i = 0; i < rays.size(); ++i) {
    EXPECT_LE((fast[i].emitted - exact[i].emitted).abs().maxCoeff(), 1e-2 * brightest) << i;
    EXPECT_NEAR(fast[i].transmittance, exact[i].transmittance, 1e-9);
  }
}

/// From the formula by many steps: a sheet of smoke between lamp and fog, and a wall.
TEST(LitMedium, WhatIsBetweenTakesItsShareAndWallsAll) {
  const Lamp lamp = lampAt(Vec3::Zero());
  const Box3 sheet{Vec3(5, -40, -40), Vec3(7, 40, 40)};
  const auto below = [](const Segment& segment, const Lamp&, std::vector<Interval>& dark) {
    dark.clear();  // a floor at z = -0.1 keeps all that is below it dark
    const double at = (-0.1 - segment.origin.z()) / segment.direction.z();
    const Interval part =
        segment.direction.z() < 0 ? Interval{at, segment.end} : Interval{segment.begin, at};
    if (!part.intersect({segment.begin, segment.end}).empty())
      dark.push_back(part.intersect({segment.begin, segment.end}));
  };
  const LitMedium medium = lit({&lamp, 1}, {}, {AnyMedium(EvenBox{sheet})}, below);
  for (const Segment& ray : {Segment{Vec3(12, 3, 9), Vec3(-0.1, 0.2, -1).normalized(), 0, 30},
                             Segment{Vec3(-20, 2, 0.5), Vec3(1, 0, 0.01).normalized(), 0, 50},
                             Segment{Vec3(9, 0, -5), Vec3(0.1, 0.1, 1).normalized(), 0, 12}}) {
    Radiance fast, pieces;
    medium.radiance({&ray, 1}, {&fast, 1});
    radianceByPieces(medium, {&ray, 1}, {&pieces, 1});
    double sum = 0;
    constexpr int kSteps = 40000;
    for (int i = 0; i < kSteps; ++i) {
      const double s = ray.end * (i + 0.5) / kSteps;
      const Vec3 point = ray.at(s);
      if (point.z() < -0.1)
        continue;
      const double far = point.norm(), near = std::max(far, lamp.radius);
      const double inSheet =
          sheet.intersect(Vec3::Zero(), point / far).intersect({0, far}).length();
      sum += kEven * std::exp(-kEven * (s + far + inSheet)) * 100 / (near * near) / (4 * kPi) *
             ray.end / kSteps;
    }
    EXPECT_NEAR(fast.emitted[0], sum, 5e-3 * sum + 1e-5);
    EXPECT_NEAR(pieces.emitted[0], sum, 5e-3 * sum + 1e-5);
  }
}

/// Edges of shadows that are almost at one place cut steps that have no length to speak of.
TEST(LitMedium, EdgesAtOnePlaceDoNoHarm) {
  const Lamp lamp = lampAt(Vec3(1, 2, 3));
  const auto dots = [](const Segment&, const Lamp&, std::vector<Interval>& dark) {
    dark.clear();
    for (const double s : {5.0, 9.0, 13.0, 33.0})
      dark.push_back({s, s + 8e-15 * s}), dark.push_back({s + 12e-15 * s, s + 1e-13 * s});
  };
  const LitMedium plain = lit({&lamp, 1}, {}), dotted = lit({&lamp, 1}, {}, {}, dots);
  const Segment ray{Vec3(-9, 2, 4), Vec3::UnitX(), 0, 40};
  Radiance expected, light;
  plain.radiance({&ray, 1}, {&expected, 1});
  dotted.radiance({&ray, 1}, {&light, 1});
  EXPECT_NEAR(light.emitted[0] / expected.emitted[0], 1, 5e-3);
}

/// A ray's end on a surface is a float, a little behind the end of the shadow of what it meets.
TEST(LitMedium, NothingIsLitBetweenAShadowAndItsSurface) {
  const Lamp lamp = lampAt(Vec3(1, 2, 3));
  const auto all = [](const Segment& segment, const Lamp&, std::vector<Interval>& dark) {
    dark.assign(1, {segment.begin, segment.end * (1 - 5e-8)});
  };
  const Segment ray{Vec3(-9, 2, 4), Vec3::UnitX(), 0, 10};
  Radiance light;
  lit({&lamp, 1}, {}, {}, all).radiance({&ray, 1}, {&light, 1});
  EXPECT_EQ(light.emitted[0], 0);
}

/// Evenly scattering, so that a point has what rays have; as far as light is known between the
/// places where it was found.
conformance::MediumUnderTest litUnderTest() {
  const Lamp lamp = lampAt(Vec3(3, -2, 60));  // outside of it, where nothing is steep
  conformance::Traits traits;
  traits.tolerance = {.closedForm = 1e-2, .points = 1e-2, .quadrature = 1e-2, .fineSteps = 1e-2};
  return conformance::underTest(lit({&lamp, 1}, {}), traits);
}

VOLUTE_CONFORMANCE(Lit, litUnderTest());

}  // namespace
}  // namespace volute
