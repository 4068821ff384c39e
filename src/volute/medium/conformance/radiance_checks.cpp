// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <cmath>

#include "volute/medium/conformance/random.hpp"
#include "volute/medium/conformance/support.hpp"

namespace volute::conformance {
namespace {

/// Relative size of what the reference integrator's quadrature leaves open, beside the medium's own
/// tolerance.
constexpr double kQuadrature = 1e-8;

Failures radianceIsFiniteAndNotNegative(const MediumUnderTest& tested) {
  Report report;
  for (const NamedSegment& named : segmentsOf(tested)) {
    const Radiance radiance = radianceOf(tested.medium, named.segment);
    const bool good = (radiance.emitted >= 0).all() && radiance.emitted.isFinite().all() &&
                      radiance.transmittance >= 0 && radiance.transmittance <= 1;
    if (!good)
      report.at(named, "radiance {}", text(radiance));
  }
  return report.take();
}

Failures emptyAndMissingSegmentsAreClear(const MediumUnderTest& tested) {
  Report report;
  std::vector<NamedSegment> segments = emptySegmentsOf(tested);
  for (NamedSegment& named : missingSegmentsOf(tested)) segments.push_back(std::move(named));
  for (const NamedSegment& named : segments) {
    const Radiance radiance = radianceOf(tested.medium, named.segment);
    if (!(radiance.emitted == 0).all() || radiance.transmittance != 1) {
      report.at(named, "radiance {}, expected none", text(radiance));
    }
  }
  return report.take();
}

Failures transmittanceIsThatOfTheDepth(const MediumUnderTest& tested) {
  Report report;
  for (const NamedSegment& named : segmentsOf(tested)) {
    const double expected = std::exp(-depthOf(tested.medium, named.segment));
    const double transmittance = radianceOf(tested.medium, named.segment).transmittance;
    if (!near(transmittance, expected, tested.traits.tolerance.closedForm, 1)) {
      report.at(named, "transmittance {:.17g}, but exp(-depth) is {:.17g}", transmittance,
                expected);
    }
  }
  return report.take();
}

Failures radianceAgreesWithPieces(const MediumUnderTest& tested) {
  Report report;
  const Scale scale = scaleOf(tested);
  for (const NamedSegment& named : segmentsOf(tested)) {
    const Radiance radiance = radianceOf(tested.medium, named.segment);
    const Radiance byPieces = composite(piecesOf(tested.medium, named.segment));
    if (!near(radiance, byPieces, tested.traits.tolerance.closedForm + kQuadrature, scale)) {
      report.at(named, "radiance {}, but its pieces give {}", text(radiance), text(byPieces));
    }
  }
  return report.take();
}

Failures splitRadiancesCompose(const MediumUnderTest& tested) {
  Report report;
  const Scale scale = scaleOf(tested);
  Random random(tested.traits.seed + 8);
  for (const NamedSegment& named : segmentsOf(tested)) {
    Segment front = named.segment, back = named.segment;
    front.end = back.begin = parameterInside(tested, named.segment, random.uniform(0.05, 0.95));
    const Radiance whole = radianceOf(tested.medium, named.segment);
    const Radiance first = radianceOf(tested.medium, front),
                   second = radianceOf(tested.medium, back);
    const Radiance composed{first.emitted + first.transmittance * second.emitted,
                            first.transmittance * second.transmittance};
    if (!near(whole, composed, tested.traits.tolerance.closedForm + kQuadrature, scale)) {
      report.at(named, "radiance {}, but {} in two parts cut at {}", text(whole), text(composed),
                front.end);
    }
  }
  return report.take();
}

/// Midpoint steps through point values.
Radiance byFineSteps(const AnyMedium& medium, const Segment& segment, const Interval& inside) {
  constexpr int kSteps = 2000;
  const double h = inside.length() / kSteps;
  Radiance radiance;
  for (int i = 0; i < kSteps; ++i) {
    const Vec3 point = segment.at(inside.begin + (i + 0.5) * h);
    const double depth = medium.extinction(point) * h;
    const double weight = depth == 0 ? 1 : -std::expm1(-depth) / depth;
    radiance.emitted += radiance.transmittance * weight * h * medium.emission(point);
    radiance.transmittance *= std::exp(-depth);
  }
  return radiance;
}

Failures radianceAgreesWithFineSteps(const MediumUnderTest& tested) {
  Report report;
  const Scale scale = scaleOf(tested);
  for (const NamedSegment& named : genericSegmentsOf(tested)) {
    const Interval inside = insideBounds(tested, named.segment);
    if (std::isinf(inside.length()))
      continue;
    const Radiance radiance = radianceOf(tested.medium, named.segment);
    const Radiance stepped = byFineSteps(tested.medium, named.segment, inside);
    if (!near(radiance, stepped, tested.traits.tolerance.fineSteps, scale)) {
      report.at(named, "radiance {}, but fine steps give {}", text(radiance), text(stepped));
    }
  }
  return report.take();
}

}  // namespace

std::vector<Check> radianceChecks() {
  return {{"RadianceIsFiniteAndNotNegative", radianceIsFiniteAndNotNegative},
          {"EmptyAndMissingSegmentsAreClear", emptyAndMissingSegmentsAreClear},
          {"TransmittanceIsThatOfTheDepth", transmittanceIsThatOfTheDepth},
          {"RadianceAgreesWithPieces", radianceAgreesWithPieces},
          {"SplitRadiancesCompose", splitRadiancesCompose},
          {"RadianceAgreesWithFineSteps", radianceAgreesWithFineSteps}};
}

}  // namespace volute::conformance
