// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "volute/medium/any_medium.hpp"

// What every medium must hold, whatever its basis: plain functions that return what they found
// wrong. conformance.hpp makes tests of them; the suite itself is tested by conformance_test.cpp,
// which seeds faults into good media and expects each to be found.

namespace volute::conformance {

/// How far two answers may lie apart, relative to the larger one or to the typical answer of the
/// medium. The defaults suit a medium that computes in double; one that loosens them says why.
struct Tolerance {
  double closedForm =
      1e-10;  ///< two ways to the same closed form; positions carry rounding of far origins
  double points = 1e-9;  ///< pieces against point values, where the points themselves are rounded
  double quadrature = 1e-6;  ///< against adaptive Simpson, which ends near jumps with such an error
  double fineSteps = 5e-3;   ///< against two thousand midpoint steps, first order at jumps
};

/// What the suite cannot ask the medium for.
struct Traits {
  /// Per axis, coordinates where the basis changes (faces of cells), ascending; rays are sent along
  /// them. Faces of finite bounds are added.
  std::array<std::vector<double>, 3> planes{};
  /// Vertices of cells that do not follow the axes; rays are sent through pairs of them.
  std::vector<Vec3> vertices{};
  /// Where points are drawn; finite. Left out, it is the bounds, cut off 10 m from 0 where they are
  /// infinite.
  Box3 region{};
  Tolerance tolerance{};
  std::uint32_t seed = 1;
};

/// The calls of a LinearMedium with its type forgotten.
struct LinearCalls {
  std::vector<double> coefficients;
  std::function<AnyMedium(std::span<const double>)> withCoefficients;
  std::function<std::vector<double>(std::span<const double>)>
      coefficientsAfter;  ///< there and back
};

/// A medium and all that a check wants of it.
struct MediumUnderTest {
  AnyMedium medium;
  Traits traits;
  std::function<void(std::span<const Segment>, std::span<double>)>
      directDepth;  ///< not through AnyMedium
  std::function<void(std::span<const Segment>, std::span<std::vector<Piece>>)> directPieces;
  std::optional<LinearCalls> linear;
};

/// Completes region and planes from the bounds of the medium.
Traits completed(Traits traits, const Box3& bounds);

template <Medium M>
MediumUnderTest underTest(const M& medium, Traits traits = {}) {
  MediumUnderTest tested{
      AnyMedium(medium), completed(std::move(traits), medium.bounds()), {}, {}, {}};
  tested.directDepth = [medium](std::span<const Segment> s, std::span<double> d) {
    medium.opticalDepth(s, d);
  };
  tested.directPieces = [medium](std::span<const Segment> s, std::span<std::vector<Piece>> p) {
    medium.pieces(s, p);
  };
  if constexpr (LinearMedium<M>) {
    tested.linear = LinearCalls{
        medium.coefficients(),
        [medium](std::span<const double> c) { return AnyMedium(M(medium.withCoefficients(c))); },
        [medium](std::span<const double> c) -> std::vector<double> {
          return M(medium.withCoefficients(c)).coefficients();
        }};
  }
  return tested;
}

/// What a check found wrong, in sentences that name the segment; empty when all is well.
using Failures = std::vector<std::string>;

struct Check {
  const char* name;
  Failures (*run)(const MediumUnderTest&);
  bool linearOnly = false;  ///< only for media with coefficients
};

/// All checks, the quick ones first.
std::vector<Check> checks();

}  // namespace volute::conformance
