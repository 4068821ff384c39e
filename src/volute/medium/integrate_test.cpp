// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/medium/integrate.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <limits>

#include "volute/math/quadrature.hpp"
#include "volute/medium/any_medium.hpp"

namespace volute {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double number(double from, double to) {
  return from + (to - from) * (*rc::gen::inRange(0, 1000001)) / 1e6;
}

/// A cubic that is positive on [0, length]: the square of a line times another positive line, plus
/// a constant.
Cubic positiveCubic(double length, double size) {
  const double a = number(-1, 1), b = number(-1, 1), c = number(0.1, 1), d = number(0, 1);
  return Cubic{{a * a * c + 0.01, 2 * a * b * c + a * a * d, b * b * c + 2 * a * b * d, b * b * d}}
             .shifted(0) *
         (size / (1 + length * length * length));
}

Piece randomPiece(double begin, double length, double decay) {
  Piece piece{begin, begin + length, positiveCubic(length, number(0, 5)), {}, decay};
  for (Polynomial& emission : piece.emission) emission = positiveCubic(length, number(0, 3));
  return piece;
}

/// Midpoint steps so fine that nothing but their number matters.
Radiance byFineSteps(std::span<const std::vector<Piece>> media, double begin, double end,
                     int steps) {
  Radiance radiance;
  const double h = (end - begin) / steps;
  for (int i = 0; i < steps; ++i) {
    const double s = begin + (i + 0.5) * h;
    double extinction = 0;
    Rgb emission = Rgb::Zero();
    for (const auto& pieces : media) {
      for (const Piece& piece : pieces) {
        if (s < piece.begin || s >= piece.end)
          continue;
        const double u = s - piece.begin;
        const double fade = std::exp(-piece.decay * u);
        extinction += piece.extinction(u) * fade;
        for (int channel = 0; channel < 3; ++channel)
          emission[channel] += piece.emission[channel](u) * fade;
      }
    }
    radiance.emitted += radiance.transmittance * std::exp(-0.5 * extinction * h) * emission * h;
    radiance.transmittance *= std::exp(-extinction * h);
  }
  return radiance;
}

Cubic constant(double value) {
  return {{value, 0, 0, 0}};
}

void expectNear(const Radiance& a, const Radiance& b, double tolerance) {
  for (int channel = 0; channel < 3; ++channel) {
    EXPECT_NEAR(a.emitted[channel], b.emitted[channel],
                tolerance * (1 + std::abs(b.emitted[channel])));
  }
  EXPECT_NEAR(a.transmittance, b.transmittance, tolerance);
}

// ---- decayingIntegral

TEST(DecayingIntegral, OfAConstantIsTheTextbookOne) {
  for (double x :
       {-600.0, -17.0, -16.0, -3.0, -1e-3, -1e-12, 1e-300, 1e-9, 0.1, 15.9, 16.1, 300.0}) {
    EXPECT_NEAR(decayingIntegral(constant(3), x / 2, 2) / (3 * -std::expm1(-x) / (x / 2)), 1, 4e-15)
        << x;
  }
}

TEST(DecayingIntegral, WithoutDecayIsThatOfTheCubic) {
  const Cubic cubic{{1, -2, 3, -4}};
  EXPECT_DOUBLE_EQ(decayingIntegral(cubic, 0, 1.5), cubic.integral(1.5));
  EXPECT_NEAR(decayingIntegral(cubic, 1e-14, 1.5), cubic.integral(1.5), 1e-12);
}

TEST(DecayingIntegral, ToInfinityIsFactorialsOverPowers) {
  EXPECT_DOUBLE_EQ(decayingIntegral({{1, 1, 1, 1}}, 2, kInfinity),
                   1 / 2.0 + 1 / 4.0 + 2 / 8.0 + 6 / 16.0);
  EXPECT_EQ(decayingIntegral({}, 0, kInfinity), 0);
  EXPECT_EQ(decayingIntegral(constant(1), 0, kInfinity), kInfinity);
  EXPECT_NEAR(decayingIntegral({{1, 1, 1, 1}}, 2, 40),
              decayingIntegral({{1, 1, 1, 1}}, 2, kInfinity), 1e-14);
}

RC_GTEST_PROP(DecayingIntegral, AgreesWithGaussOnManySmallParts, ()) {
  const double length = number(0.01, 10);
  const double decay = number(-40, 40) / length;
  const Cubic cubic = positiveCubic(length, 1);
  double byGauss = 0;
  constexpr int kParts = 64;
  for (int i = 0; i < kParts; ++i) {
    byGauss += gaussIntegral(8, length * i / kParts, length * (i + 1) / kParts,
                             [&](double u) { return cubic(u) * std::exp(-decay * u); });
  }
  RC_ASSERT(std::abs(decayingIntegral(cubic, decay, length) - byGauss) <=
            1e-12 * std::abs(byGauss));
}

RC_GTEST_PROP(DecayingIntegral, AgreesWithGaussForEveryPower, ()) {
  const double length = number(0.1, 3);
  const double decay = number(-60, 60) / length;
  for (int n = 0; n < Polynomial::kTerms; ++n) {
    Polynomial power;
    power.c[n] = 1;
    double byGauss = 0;
    for (int i = 0; i < 64; ++i) {
      byGauss += gaussIntegral(8, length * i / 64, length * (i + 1) / 64,
                               [&](double u) { return power(u) * std::exp(-decay * u); });
    }
    RC_ASSERT(std::abs(decayingIntegral(power, decay, length) - byGauss) <= 1e-12 * byGauss);
  }
}

RC_GTEST_PROP(DecayingIntegral, IsContinuousWhereTheMethodChanges, ()) {
  const Cubic cubic = positiveCubic(1, 1);
  for (double x : {-16.0, 0.0, 16.0}) {
    const double below = decayingIntegral(cubic, std::nextafter(x, -20.0), 1);
    const double above = decayingIntegral(cubic, std::nextafter(x, 20.0), 1);
    RC_ASSERT(std::abs(below - above) <= 1e-13 * above);
  }
}

RC_GTEST_PROP(Clipped, PartsAddUpToThePiece, ()) {
  const double length = number(0.1, 5);
  const Piece piece = randomPiece(number(-3, 3), length, number(-5, 5));
  const double cut = piece.begin + length * number(0.01, 0.99);
  const Piece front = clipped(piece, piece.begin, cut), back = clipped(piece, cut, piece.end);
  const double depth = pieceOpticalDepth(piece);
  RC_ASSERT(std::abs(pieceOpticalDepth(front) + pieceOpticalDepth(back) - depth) <= 1e-12 * depth);
  const Rgb sum = pieceEmission(front) + pieceEmission(back);
  RC_ASSERT((sum - pieceEmission(piece)).abs().maxCoeff() <= 1e-11 * (1e-3 + sum.maxCoeff()));
}

// ---- composite

TEST(Composite, OfNothingIsEmptySpace) {
  double bound = 1;
  expectNear(composite({}, &bound), {}, 0);
  EXPECT_EQ(bound, 0);
  expectNear(compositeMedia({}), {}, 0);
}

TEST(Composite, OfAConstantMediumIsTheClosedFormForEveryExtinction) {
  for (double extinction : {1e-310, 1e-20, 1e-9, 1e-3, 1.0, 50.0, 1e6}) {
    const Piece piece{2, 5, constant(extinction), {constant(7), constant(0), constant(1e-3)}, 0};
    double bound = 1;
    const Radiance radiance = composite({&piece, 1}, &bound);
    const double factor = extinction < 1e-300 ? 3 : -std::expm1(-3 * extinction) / extinction;
    EXPECT_NEAR(radiance.emitted[0] / (7 * factor), 1, 1e-14) << extinction;
    EXPECT_EQ(radiance.emitted[1], 0);
    EXPECT_NEAR(radiance.emitted[2] / (1e-3 * factor), 1, 1e-14) << extinction;
    EXPECT_DOUBLE_EQ(radiance.transmittance, std::exp(-3 * extinction));
    EXPECT_EQ(bound, 0) << "the closed form has no quadrature error";
  }
}

TEST(Composite, OfAnInfiniteOpaqueFogIsItsColour) {
  const Piece piece{2, kInfinity, constant(0.1), {constant(0.2), constant(0.1), constant(0)}, 0};
  const Radiance radiance = composite({&piece, 1});
  EXPECT_DOUBLE_EQ(radiance.emitted[0], 2);
  EXPECT_DOUBLE_EQ(radiance.emitted[1], 1);
  EXPECT_EQ(radiance.emitted[2], 0);
  EXPECT_EQ(radiance.transmittance, 0);
}

TEST(Composite, OfPureEmissionIsTheLineIntegral) {
  const Piece piece{-1, 1, {}, {Cubic{{1, 2, 3, 4}}, Cubic{{0, 0, 0, 1}}, Cubic{}}, 0};
  const Radiance radiance = composite({&piece, 1});
  EXPECT_DOUBLE_EQ(radiance.emitted[0], 2 + 4 + 8 + 16);
  EXPECT_DOUBLE_EQ(radiance.emitted[1], 4);
  EXPECT_EQ(radiance.transmittance, 1);
}

TEST(Composite, OfLinearEmissionInConstantExtinctionIsItsAntiderivative) {
  // integral of u exp(-k u) from 0 to L = (1 - (1 + k L) exp(-k L)) / k^2; a thin bright front for
  // large k.
  for (double k : {0.5, 4.0, 1e3, 1e6}) {
    const Piece piece{0, 2, constant(k), {Cubic{{0, 1, 0, 0}}, constant(k), Cubic{}}, 0};
    double bound = 0;
    const Radiance radiance = composite({&piece, 1}, &bound);
    const double exact = (1 - (1 + 2 * k) * std::exp(-2 * k)) / (k * k);
    EXPECT_NEAR(radiance.emitted[0] / exact, 1, 1e-10) << k;
    EXPECT_NEAR(radiance.emitted[1], -std::expm1(-2 * k), 1e-10) << k;
    EXPECT_LT(bound, 1e-9);
  }
}

TEST(Composite, OfAnInfiniteAtmosphereMeetsTheFiniteOne) {
  const Cubic glow{{1, 0.5, 0, 0}};
  const Piece infinite{0, kInfinity, constant(0.3), {glow, constant(1), constant(0)}, 0.1};
  Piece finite = infinite;
  finite.end = 600;
  expectNear(composite({&infinite, 1}), composite({&finite, 1}), 1e-10);
}

TEST(Composite, EndsOnPiecesWithoutMeaning) {
  const double nan = std::nan("");
  const Cubic wild{{-1e300, 1e300, nan, 1}}, huge{{-1e20, 1e20, -1e20, 1e20}},
      noisy{{1e18, -3e18, 3e18, -1e18}};
  for (const Cubic& cubic : {wild, huge, noisy}) {
    const Piece piece{0, 3, cubic, {huge, wild, Cubic{{1, 2, 3, 4}}}, -200};
    composite({&piece, 1});
  }
}

RC_GTEST_PROP(Composite, AgreesWithFineStepsWithinTheBound, ()) {
  const double length = number(0.1, 4);
  std::vector<std::vector<Piece>> media(1);
  media[0] = {randomPiece(1, length, 0), randomPiece(1.5 + length, length, number(-3, 3) / length)};
  double bound = 1;
  const Radiance radiance = composite(media[0], &bound);
  const Radiance steps = byFineSteps(media, 1, 1.5 + 2 * length, 20000);
  RC_ASSERT((radiance.emitted - steps.emitted).abs().maxCoeff() <=
            1e-3 * (1e-3 + steps.emitted.maxCoeff()));
  RC_ASSERT(std::abs(radiance.transmittance - steps.transmittance) <= 1e-3);
  RC_ASSERT(bound <= 1e-9 * (1 + radiance.emitted.maxCoeff()));
}

RC_GTEST_PROP(Composite, DoesNotDependOnWhereAPieceIsCut, ()) {
  const double length = number(0.1, 4);
  const Piece piece = randomPiece(0, length, number(-6, 6) / length);
  const double cut = length * number(0.01, 0.99);
  const std::vector<Piece> parts{clipped(piece, 0, cut), clipped(piece, cut, length)};
  const Radiance whole = composite({&piece, 1}), split = composite(parts);
  RC_ASSERT((whole.emitted - split.emitted).abs().maxCoeff() <=
            1e-9 * (1e-3 + whole.emitted.maxCoeff()));
  RC_ASSERT(std::abs(whole.transmittance - split.transmittance) <= 1e-12);
}

// ---- compositeMedia

RC_GTEST_PROP(CompositeMedia, OfOneMediumIsComposite, ()) {
  const std::vector<std::vector<Piece>> media{
      {randomPiece(0, 1, 0.3), randomPiece(1, 0.5, 0), randomPiece(3, 1, 0)}};
  const Radiance a = compositeMedia(media), b = composite(media[0]);
  RC_ASSERT((a.emitted - b.emitted).abs().maxCoeff() == 0);
  RC_ASSERT(a.transmittance == b.transmittance);
}

RC_GTEST_PROP(CompositeMedia, OverlappingMediaAddUpAsFineStepsDo, ()) {
  const std::vector<std::vector<Piece>> media{
      {randomPiece(0, 2, number(-1, 1)), randomPiece(2, 1, 0)},
      {randomPiece(number(0, 1), 1.5, 0)},
      {},
      {randomPiece(number(-1, 0), 1, 0.5), randomPiece(2.5, 2, -0.5)}};
  double bound = 1;
  const Radiance radiance = compositeMedia(media, &bound);
  const Radiance steps = byFineSteps(media, -1, 4.5, 40000);
  RC_ASSERT((radiance.emitted - steps.emitted).abs().maxCoeff() <=
            1e-3 * (1e-3 + steps.emitted.maxCoeff()));
  RC_ASSERT(std::abs(radiance.transmittance - steps.transmittance) <= 1e-3);
  RC_ASSERT(bound <= 1e-9 * (1 + radiance.emitted.maxCoeff()));
}

RC_GTEST_PROP(CompositeMedia, TheOrderOfTheMediaDoesNotMatter, ()) {
  const std::vector<Piece> a{randomPiece(0, 2, 0.7)}, b{randomPiece(1, 2, 0)},
      c{randomPiece(0.5, 4, -0.2)};
  const Radiance abc = compositeMedia(std::vector{a, b, c}),
                 cba = compositeMedia(std::vector{c, b, a});
  RC_ASSERT((abc.emitted - cba.emitted).abs().maxCoeff() <= 1e-9 * (1e-3 + abc.emitted.maxCoeff()));
  RC_ASSERT(std::abs(abc.transmittance - cba.transmittance) <= 1e-12);
}

TEST(CompositeMedia, TwoHalvesOfAFogAreTheFog) {
  const Piece half{0, 3, constant(0.25), {constant(1), constant(2), constant(3)}, 0};
  const Piece fog{0, 3, constant(0.5), {constant(2), constant(4), constant(6)}, 0};
  double bound = 1;
  expectNear(compositeMedia(std::vector<std::vector<Piece>>{{half}, {half}}, &bound),
             composite({&fog, 1}), 1e-15);
  EXPECT_EQ(bound, 0);
}

// ---- integralOfPoints

TEST(IntegralOfPoints, ClipsToBoundsAndReachesInfinity) {
  const Box3 box{Vec3(0, 0, 0), Vec3(1, 1, 2)};
  const auto one = [](const Vec3&) { return 1.0; };
  const auto along = [](const Vec3& d, double begin, double end) {
    return Segment{Vec3(0.5, 0.5, 0.5), d, begin, end};
  };
  EXPECT_NEAR(integralOfPoints(one, box, along(Vec3::UnitZ(), -kInfinity, kInfinity), 1e-9), 2,
              1e-9);
  EXPECT_NEAR(integralOfPoints(one, box, along(Vec3::UnitZ(), 0, 0.75), 1e-9), 0.75, 1e-9);
  EXPECT_EQ(integralOfPoints(one, box, along(Vec3::UnitX(), 2, 3), 1e-9), 0);

  const Box3 everywhere{Vec3::Constant(-kInfinity), Vec3::Constant(kInfinity)};
  const auto bell = [](const Vec3& p) { return std::exp(-p.squaredNorm()); };
  const Segment line{Vec3::Zero(), Vec3::UnitY(), -kInfinity, kInfinity};
  EXPECT_NEAR(integralOfPoints(bell, everywhere, line, 1e-9), std::sqrt(M_PI), 1e-8);
}

}  // namespace
}  // namespace volute
