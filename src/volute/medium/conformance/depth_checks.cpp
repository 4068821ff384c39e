// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>
#include <cmath>
#include <limits>

#include "volute/medium/conformance/random.hpp"
#include "volute/medium/conformance/support.hpp"

namespace volute::conformance {
namespace {

constexpr double kEndless = std::numeric_limits<double>::infinity();

Failures boundsAreABox(const MediumUnderTest& tested) {
  if (tested.medium.bounds().empty())
    return {"the bounds are empty or not a number"};
  return {};
}

Failures nothingIsOutsideTheBounds(const MediumUnderTest& tested) {
  Report report;
  Random random(tested.traits.seed + 3);
  const Box3 bounds = tested.medium.bounds();
  for (int i = 0; i < 300; ++i) {
    Vec3 point = random.pointIn(tested.traits.region);
    const int axis = i % 3;
    const double face = i % 2 ? bounds.max[axis] : bounds.min[axis];
    if (std::isinf(face))
      continue;
    const double distance = i < 60 ? 1e-6 : random.uniform(0, 1);
    point[axis] = face + (i % 2 ? 1 : -1) * distance * tested.traits.region.size()[axis];
    const double extinction = tested.medium.extinction(point);
    const Rgb emission = tested.medium.emission(point);
    if (extinction != 0 || !(emission == 0).all()) {
      report.add(
          "point ({}, {}, {}) is outside of the bounds, but has extinction {} and emission {}",
          point[0], point[1], point[2], extinction, text(emission));
    }
  }
  return report.take();
}

Failures pointsAreFiniteAndNotNegative(const MediumUnderTest& tested) {
  Report report;
  Random random(tested.traits.seed + 4);
  for (int i = 0; i < 300; ++i) {
    Vec3 point = random.pointIn(tested.traits.region);
    for (int axis = 0; axis < 3; ++axis) {  // some on planes, edges and corners
      const auto& planes = tested.traits.planes[axis];
      if ((i >> axis) % 2 && !planes.empty())
        point[axis] = planes[i % planes.size()];
    }
    const double extinction = tested.medium.extinction(point);
    const Rgb emission = tested.medium.emission(point);
    if (!(extinction >= 0 && std::isfinite(extinction) && (emission >= 0).all() &&
          emission.isFinite().all())) {
      report.add("point ({}, {}, {}) has extinction {} and emission {}", point[0], point[1],
                 point[2], extinction, text(emission));
    }
  }
  return report.take();
}

Failures depthsAreFiniteAndNotNegative(const MediumUnderTest& tested) {
  Report report;
  const Scale scale = scaleOf(tested);
  for (const NamedSegment& named : segmentsOf(tested)) {
    const double depth = depthOf(tested.medium, named.segment);
    const bool mayBeInfinite = std::isinf(insideBounds(tested, named.segment).length());
    const bool finite = std::isfinite(depth) || (mayBeInfinite && depth == kEndless);
    if (!finite || !(depth >= -tested.traits.tolerance.closedForm * scale.depth)) {
      report.at(named, "optical depth {}", depth);
    }
  }
  return report.take();
}

Failures somethingIsThere(const MediumUnderTest& tested) {
  for (const NamedSegment& named : segmentsOf(tested)) {
    if (depthOf(tested.medium, named.segment) > 0)
      return {};
    if (emissionOf(piecesOf(tested.medium, named.segment)).maxCoeff() > 0)
      return {};
  }
  return {
      "no segment through the medium has a depth or an emission: a medium of zeros passes every "
      "other check"};
}

Failures emptySegmentsHaveNoDepth(const MediumUnderTest& tested) {
  Report report;
  for (const NamedSegment& named : emptySegmentsOf(tested)) {
    const double depth = depthOf(tested.medium, named.segment);
    if (depth != 0)
      report.at(named, "optical depth {}, expected 0", depth);
  }
  return report.take();
}

Failures missingSegmentsHaveNoDepth(const MediumUnderTest& tested) {
  Report report;
  for (const NamedSegment& named : missingSegmentsOf(tested)) {
    const double depth = depthOf(tested.medium, named.segment);
    if (depth != 0)
      report.at(named, "optical depth {}, expected 0", depth);
  }
  return report.take();
}

/// Compares the depth of each segment with a depth that must be the same.
template <class Other>
Failures depthIsTheSame(const MediumUnderTest& tested, const char* how, Other&& other) {
  Report report;
  const Scale scale = scaleOf(tested);
  for (const NamedSegment& named : segmentsOf(tested)) {
    const double depth = depthOf(tested.medium, named.segment);
    const double again = other(named.segment);
    if (!near(depth, again, tested.traits.tolerance.closedForm, scale.depth)) {
      report.at(named, "optical depth {:.17g}, but {:.17g} {}", depth, again, how);
    }
  }
  return report.take();
}

Failures splitDepthsAdd(const MediumUnderTest& tested) {
  Random random(tested.traits.seed + 5);
  return depthIsTheSame(tested, "as the sum of two parts", [&](const Segment& segment) {
    const double cut = parameterInside(tested, segment, random.uniform(0.05, 0.95));
    Segment front = segment, back = segment;
    front.end = back.begin = cut;
    return depthOf(tested.medium, front) + depthOf(tested.medium, back);
  });
}

Failures depthsAreTheSameBackwards(const MediumUnderTest& tested) {
  return depthIsTheSame(tested, "backwards", [&](const Segment& segment) {
    return depthOf(tested.medium, backwards(segment));
  });
}

Failures originsMayMoveAlongTheRay(const MediumUnderTest& tested) {
  Random random(tested.traits.seed + 6);
  return depthIsTheSame(tested, "from another origin on the same ray", [&](const Segment& segment) {
    const double shift = parameterInside(tested, segment, random.uniform(0, 1));
    return depthOf(tested.medium, {segment.at(shift), segment.direction, segment.begin - shift,
                                   segment.end - shift});
  });
}

Failures negativeZerosAreZeros(const MediumUnderTest& tested) {
  return depthIsTheSame(tested, "with -0 for 0 in the direction", [&](Segment segment) {
    for (double& component : segment.direction) component = component == 0 ? -0.0 : component;
    return depthOf(tested.medium, segment);
  });
}

Failures onlyTheBoundsMatter(const MediumUnderTest& tested) {
  return depthIsTheSame(tested, "for its part inside the bounds alone", [&](Segment segment) {
    const Interval inside = insideBounds(tested, segment);
    segment.begin = inside.begin;
    segment.end = inside.end;
    return inside.empty() ? 0.0 : depthOf(tested.medium, segment);
  });
}

Failures depthsGrowWithTheSegment(const MediumUnderTest& tested) {
  Report report;
  const Scale scale = scaleOf(tested);
  for (const NamedSegment& named : segmentsOf(tested)) {
    double last = 0;
    for (double share : {0.1, 0.3, 0.5, 0.7, 0.9}) {
      Segment part = named.segment;
      part.end = parameterInside(tested, named.segment, share);
      const double depth = depthOf(tested.medium, part);
      if (!(depth >= last - tested.traits.tolerance.closedForm * std::max(last, scale.depth))) {
        report.at(named, "optical depth falls from {} to {} when the segment grows to {}", last,
                  depth, part.end);
      }
      last = depth;
    }
  }
  return report.take();
}

Failures depthsAlongFacesAreThoseOfASide(const MediumUnderTest& tested) {
  constexpr double kAside =
      1e-8;  // of the region: what may change over it is far below the tolerance,
  constexpr double kTolerance = 1e-5;  // unless the medium jumps there
  Report report;
  const Scale scale = scaleOf(tested);
  for (const NamedSegment& named : segmentsOf(tested)) {
    if (named.sides.empty())
      continue;
    double least = kEndless, most = -kEndless;
    for (const Vec3& side : named.sides) {
      Segment beside = named.segment;
      beside.origin += kAside * scale.length * side;
      const double depth = depthOf(tested.medium, beside);
      least = std::min(least, depth);
      most = std::max(most, depth);
    }
    const double depth = depthOf(tested.medium, named.segment);
    const double slack = kTolerance * std::max(scale.depth, std::isfinite(most) ? most : 0);
    if (!(depth >= least - slack && depth <= most + slack)) {
      report.at(named, "optical depth {}, but the sides have {} to {}", depth, least, most);
    }
  }
  return report.take();
}

Failures depthsAgreeWithQuadrature(const MediumUnderTest& tested) {
  Report report;
  const Scale scale = scaleOf(tested);
  const double tolerance = tested.traits.tolerance.quadrature;
  for (const NamedSegment& named : genericSegmentsOf(tested)) {
    const double depth = depthOf(tested.medium, named.segment);
    if (std::isinf(depth))
      continue;
    const double byQuadrature =
        opticalDepthByQuadrature(tested.medium, named.segment, 0.01 * tolerance * scale.depth);
    if (!near(depth, byQuadrature, tolerance, scale.depth)) {
      report.at(named,
                "optical depth {:.12g}, but quadrature of the extinction at points gives {:.12g}",
                depth, byQuadrature);
    }
  }
  return report.take();
}

}  // namespace

std::vector<Check> depthChecks() {
  return {{"BoundsAreABox", boundsAreABox},
          {"NothingIsOutsideTheBounds", nothingIsOutsideTheBounds},
          {"PointsAreFiniteAndNotNegative", pointsAreFiniteAndNotNegative},
          {"DepthsAreFiniteAndNotNegative", depthsAreFiniteAndNotNegative},
          {"SomethingIsThere", somethingIsThere},
          {"EmptySegmentsHaveNoDepth", emptySegmentsHaveNoDepth},
          {"MissingSegmentsHaveNoDepth", missingSegmentsHaveNoDepth},
          {"SplitDepthsAdd", splitDepthsAdd},
          {"DepthsAreTheSameBackwards", depthsAreTheSameBackwards},
          {"OriginsMayMoveAlongTheRay", originsMayMoveAlongTheRay},
          {"NegativeZerosAreZeros", negativeZerosAreZeros},
          {"OnlyTheBoundsMatter", onlyTheBoundsMatter},
          {"DepthsGrowWithTheSegment", depthsGrowWithTheSegment},
          {"DepthsAlongFacesAreThoseOfASide", depthsAlongFacesAreThoseOfASide},
          {"DepthsAgreeWithQuadrature", depthsAgreeWithQuadrature}};
}

}  // namespace volute::conformance
