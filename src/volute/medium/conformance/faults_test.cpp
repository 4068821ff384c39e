// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "volute/medium/conformance.hpp"
#include "volute/medium/conformance/dummy_media.hpp"
#include "volute/medium/conformance/faulty.hpp"

// The suite is tested too: good media with one fault each, of the kinds that real media have had.
// At least one check must find each.

namespace volute::conformance {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

bool hasZero(const Vec3& direction) {
  return (direction.array() == 0).any();
}

bool hasNegativeZero(const Vec3& direction) {
  for (double component : direction) {
    if (component == 0 && std::signbit(component))
      return true;
  }
  return false;
}

std::vector<Fault> faultsOfSegments() {
  return {
      {.name = "IgnoresBegin", .segment = [](Segment s) { return s.begin = -kInfinity, s; }},
      {.name = "IgnoresEnd",
       .segment = [](Segment s) { return s.end = s.begin < s.end ? kInfinity : s.end, s; }},
      {.name = "TakesEmptySegmentsForReversedOnes",
       .segment =
           [](Segment s) {
             return s.begin > s.end ? Segment{s.origin, s.direction, s.end, s.begin} : s;
           }},
      {.name = "BeginsBehindTheOriginNever",
       .segment = [](Segment s) { return s.begin = std::max(s.begin, 0.0), s; }},
      {.name = "SeesNothingAtInfinity",
       .segment = [](Segment s) { return s.end = std::isinf(s.end) ? s.begin : s.end, s; }},
      {.name = "MissesOnNegativeZeros",
       .segment =
           [](Segment s) { return s.end = hasNegativeZero(s.direction) ? s.begin : s.end, s; }},
      {.name = "TakesTheCellOneFurtherAlongFaces",
       .segment =
           [](Segment s) {
             const auto planes = trilinearVoxelsUnderTest().traits.planes;
             for (int axis = 0; axis < 3; ++axis) {
               const bool along =
                   s.direction[axis] == 0 &&
                   std::count(planes[axis].begin(), planes[axis].end(), s.origin[axis]);
               if (along)
                 s.origin[axis] += 1.5 * (planes[axis][1] - planes[axis][0]);
             }
             return s;
           }},
  };
}

std::vector<Fault> faultsOfDepths() {
  return {
      {.name = "ClampsTheDepth",
       .depth = [](const Segment&, double depth) { return std::min(depth, 0.3); }},
      {.name = "IsNotANumberOnZeroComponents",
       .depth = [](const Segment& s,
                   double depth) { return hasZero(s.direction) ? std::nan("") : depth; }},
      {.name = "EmptySegmentsAreNegative",
       .depth =
           [](const Segment& s, double depth) {
             return s.empty() && std::isfinite(s.begin - s.end) ? s.end - s.begin : depth;
           }},
      {.name = "LeaksFromTheSegmentBefore",
       .depthBatch =
           [](std::span<double> depths) {
             for (std::size_t i = 1; i < depths.size(); ++i) depths[i] += 1e-6 * depths[i - 1];
           }},
      {.name = "DiffersInWideBatches",
       .depthBatch =
           [](std::span<double> depths) {
             if (depths.size() >= 8)
               depths[7] *= 1 + 1e-7;
           }},
      {.name = "IsOnePercentOff",
       .depth = [](const Segment&, double depth) { return 1.01 * depth; }},
      {.name = "DependsOnTheDirection",
       .depth = [](const Segment& s,
                   double depth) { return depth * (1 + 1e-6 * s.direction.x()); }},
  };
}

std::vector<Fault> faultsOfPieces() {
  const auto loseLast = [](const Segment&, std::vector<Piece>& pieces) {
    if (!pieces.empty())
      pieces.pop_back();
  };
  const auto emission = [](double factor) {
    return [factor](const Segment&, std::vector<Piece>& pieces) {
      for (Piece& piece : pieces) piece.emission[2] = piece.emission[2] * factor;
    };
  };
  return {
      {.name = "LosesTheLastPiece", .pieces = loseLast},
      {.name = "LosesTheLastPieceInTheDepthToo", .pieces = loseLast, .depthByPieces = true},
      {.name = "ForgetsAChannel", .pieces = emission(0)},
      {.name = "EmitsALittleMuch", .pieces = emission(1.001)},
      {.name = "PiecesOverlap",
       .pieces =
           [](const Segment&, std::vector<Piece>& pieces) {
             for (Piece& piece : pieces) piece.end += 0.01 * (piece.end - piece.begin);
           }},
      {.name = "PiecesComeBackToFront",
       .pieces = [](const Segment&,
                    std::vector<Piece>& pieces) { std::reverse(pieces.begin(), pieces.end()); }},
      {.name = "PiecesAreAppended", .appendsPieces = true},
      {.name = "CurvesAreNotMirrored",
       .pieces =
           [](const Segment& s, std::vector<Piece>& pieces) {
             if (s.direction.x() >= 0)
               return;
             for (Piece& piece : pieces) {  // p(length - u): the same integral
               Polynomial turned = piece.extinction.shifted(piece.end - piece.begin);
               for (int i = 1; i < Polynomial::kTerms; i += 2) turned.c[i] = -turned.c[i];
               if (std::isfinite(piece.end))
                 piece.extinction = turned;
             }
           }},
      {.name = "CurvesBeginAtTheOrigin",
       .pieces =
           [](const Segment&, std::vector<Piece>& pieces) {
             for (Piece& piece : pieces) piece.extinction = piece.extinction.shifted(-piece.begin);
           }},
      {.name = "EmptySegmentsHaveAPiece",
       .pieces =
           [](const Segment& s, std::vector<Piece>& pieces) {
             if (s.empty())
               pieces.push_back({s.begin, s.end, {}, {}, 0});
           }},
      {.name = "RadianceIsNotAbsorbed",
       .radiance = [](const Segment&, Radiance& r) { r.emitted /= std::sqrt(r.transmittance); }},
      {.name = "TransmittanceIsOfHalfTheDepth",
       .radiance = [](const Segment&,
                      Radiance& r) { r.transmittance = std::sqrt(r.transmittance); }},
  };
}

std::vector<Fault> faultsOfPoints() {
  return {
      {.name = "BoundsAreTooSmall",
       .bounds =
           [](Box3 box) { return Box3{box.min, box.max - 0.1 * Vec3(box.size().x(), 0, 0)}; }},
      {.name = "BoundsAreEmpty", .bounds = [](Box3) { return Box3{}; }},
      {.name = "PointsReachOutside",
       .point = [](const Vec3&, double value) { return value + 1e-3; }},
      {.name = "PointsAreWrongOnOneSide",
       .point = [](const Vec3& p, double value) { return p.y() > 1.5 ? 1.001 * value : value; }},
  };
}

std::vector<Fault> faultsOfCoefficients() {
  const auto each = [](double (*f)(double)) {
    return [f](std::vector<double> c) {
      for (double& value : c) value = f(value);
      return c;
    };
  };
  return {
      {.name = "CoefficientsAreSquared", .coefficients = each([](double c) { return c * c; })},
      {.name = "CoefficientsAreClamped",
       .coefficients = each([](double c) { return std::min(c, 0.9); })},
      {.name = "CoefficientsHaveAFloor",
       .coefficients = each([](double c) { return std::max(c, 0.01); })},
      {.name = "CoefficientsAreFloats",
       .coefficients = each([](double c) { return double(float(c)); })},
  };
}

/// The first check that finds something, with what it says.
std::string firstFinding(const MediumUnderTest& tested) {
  for (const Check& check : checks()) {
    if (check.linearOnly && !tested.linear)
      continue;
    const Failures failures = check.run(tested);
    if (!failures.empty())
      return fmt::format("{}: {}", check.name, failures.front());
  }
  return {};
}

std::vector<Fault> allFaults() {
  std::vector<Fault> all;
  for (const auto& group : {faultsOfSegments(), faultsOfDepths(), faultsOfPieces(),
                            faultsOfPoints(), faultsOfCoefficients()}) {
    all.insert(all.end(), group.begin(), group.end());
  }
  return all;
}

class SeededFault : public ::testing::TestWithParam<Fault> {};

TEST_P(SeededFault, IsFoundInVoxels) {
  const TrilinearVoxels voxels({4, 3, 4}, Vec3(-1, 0.5, 2), Vec3(0.5, 0.75, 0.25), 3);
  const std::string finding = firstFinding(underTest(Faulty(voxels, GetParam()), traitsOf(voxels)));
  EXPECT_FALSE(finding.empty()) << "no check finds this fault";
  RecordProperty("found_by", finding);
}

INSTANTIATE_TEST_SUITE_P(All, SeededFault, ::testing::ValuesIn(allFaults()),
                         [](const auto& info) { return info.param.name; });

// The wrapper itself must not be what the checks find.
TEST(SeededFaults, NoneIsFoundWhereNoneIs) {
  const TrilinearVoxels voxels({4, 3, 4}, Vec3(-1, 0.5, 2), Vec3(0.5, 0.75, 0.25), 3);
  EXPECT_EQ(firstFinding(underTest(Faulty(voxels, Fault{.name = "None"}), traitsOf(voxels))), "");
  const Atmosphere atmosphere(0.2);
  EXPECT_EQ(
      firstFinding(underTest(Faulty(atmosphere, Fault{.name = "None"}), traitsOf(atmosphere))), "");
}

TEST(SeededFaults, DecayOfTheWrongSignIsFound) {
  const Atmosphere atmosphere(0.2);
  Fault fault{.name = "DecayOfTheWrongSign",
              .pieces = [](const Segment&, std::vector<Piece>& pieces) {
                for (Piece& piece : pieces)
                  piece.decay = std::isfinite(piece.end) ? -piece.decay : piece.decay;
              }};
  EXPECT_NE(firstFinding(underTest(Faulty(atmosphere, fault), traitsOf(atmosphere))), "");
  fault.depthByPieces = true;
  EXPECT_NE(firstFinding(underTest(Faulty(atmosphere, fault), traitsOf(atmosphere))), "")
      << "in the depth as well";
}

TEST(SeededFaults, ABoxLostBehindAGapIsFound) {
  const TwoBoxes boxes({0.8, 0.3, 2.0});
  const Fault fault{.name = "LosesWhatComesAfterAGap",
                    .pieces =
                        [](const Segment&, std::vector<Piece>& pieces) {
                          pieces.resize(std::min<std::size_t>(pieces.size(), 1));
                        },
                    .depthByPieces = true};
  EXPECT_NE(firstFinding(underTest(Faulty(boxes, fault), traitsOf(boxes))), "");
}

/// Satisfies every identity there is.
struct Nothing {
  Box3 bounds() const { return {Vec3::Zero(), Vec3::Ones()}; }

  double extinction(const Vec3&) const { return 0; }

  Rgb emission(const Vec3&) const { return Rgb::Zero(); }

  void opticalDepth(std::span<const Segment>, std::span<double> depths) const {
    std::fill(depths.begin(), depths.end(), 0.0);
  }

  void pieces(std::span<const Segment>, std::span<std::vector<Piece>> pieces) const {
    for (auto& list : pieces) list.clear();
  }
};

TEST(SeededFaults, NothingAtAllIsFound) {
  EXPECT_NE(firstFinding(underTest(Nothing())), "");
}

}  // namespace
}  // namespace volute::conformance
