// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/lighting/lamp_lit_medium.hpp"

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

LampLitMedium lit(std::span<const Lamp> lamps, const LampScattering& scattering) {
  const AnyMedium even{EvenBox()};
  return {even, even, lamps, scattering};
}

TEST(LampLitMedium, SendsWhatArrivesAtAPoint) {
  const Lamp lamp = lampAt(Vec3(1, 2, 3));
  const LampLitMedium medium = lit({&lamp, 1}, {.albedo = Rgb(0.9, 0.8, 0.7)});
  for (const Vec3& away : {Vec3(3, 1, -2), Vec3(-9, 4, 7), Vec3(0.2, -20, 1)}) {
    const double far = away.norm();
    const Rgb expected = kEven * Rgb(0.9, 0.8, 0.7) * lamp.intensity / (far * far) *
                         std::exp(-kEven * far) / (4 * kPi);
    const Rgb found = medium.emission(lamp.position + away);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c] / expected[c], 1, 5e-3);
  }
}

/// All light that a ball around the lamp scatters is what it does not let out.
TEST(LampLitMedium, ScattersTheLampsPower) {
  const Lamp lamp = lampAt(Vec3::Zero());
  const LampLitMedium medium = lit({&lamp, 1}, {});
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

TEST(LampLitMedium, FastPathIsTheIntegralOfItsFormula) {
  const Lamp lamp = lampAt(Vec3(1, 2, 3));
  const LampLitMedium medium = lit({&lamp, 1}, {.albedo = Rgb::Constant(0.9), .asymmetry = 0.6});
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
    EXPECT_NEAR(fast[i].emitted[0], expected[i], 1e-2 * brightest) << i;
}

TEST(LampLitMedium, FastPathIsThatOfItsPieces) {
  const Lamp lamps[] = {lampAt(Vec3(0, 0, 0)), lampAt(Vec3(1, 0.5, 2), Rgb(30, 30, 60)),
                        lampAt(Vec3(-1, 1, 3))};
  const LampLitMedium medium = lit(lamps, {.asymmetry = 0.3});
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

TEST(LampLitMedium, WhatIsBetweenTakesItsShare) {
  const Lamp lamp = lampAt(Vec3::Zero());
  const AnyMedium thin(EvenBox{{Vec3(5, -40, -40), Vec3(7, 40, 40)}});
  const Blocks ground = [](std::span<const Segment> segments, std::span<std::uint8_t> blocked) {
    for (std::size_t i = 0; i < segments.size(); ++i) blocked[i] = segments[i].origin.z() < -10;
  };
  const LampLitMedium plain = lit({&lamp, 1}, {});
  const LampLitMedium shadowed = lit({&lamp, 1}, {.between = {&thin, 1}, .blocks = ground});
  const Vec3 behind(12, 0.3, 0.2), before(3, 0.3, 0.2), below(1, 0, -25), above(1, 0, 25);
  EXPECT_NEAR(shadowed.emission(behind)[0] / plain.emission(behind)[0], std::exp(-2 * kEven), 2e-2);
  EXPECT_NEAR(shadowed.emission(before)[0] / plain.emission(before)[0], 1, 1e-9);
  EXPECT_EQ(shadowed.emission(below)[0], 0);
  EXPECT_NEAR(shadowed.emission(above)[0] / plain.emission(above)[0], 1, 1e-2);
}

/// Evenly scattering, so that a point has what rays have; as far as light is known between the
/// places where it was found.
conformance::MediumUnderTest lampLitUnderTest() {
  const Lamp lamp = lampAt(Vec3(3, -2, 60));  // outside of it, where nothing is steep
  conformance::Traits traits;
  traits.tolerance = {.closedForm = 1e-2, .points = 1e-2, .quadrature = 1e-2, .fineSteps = 1e-2};
  return conformance::underTest(lit({&lamp, 1}, {}), traits);
}

VOLUTE_CONFORMANCE(LampLit, lampLitUnderTest());

}  // namespace
}  // namespace volute
