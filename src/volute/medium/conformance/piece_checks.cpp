// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>
#include <cmath>

#include "volute/medium/conformance/random.hpp"
#include "volute/medium/conformance/support.hpp"

namespace volute::conformance {
namespace {

/// Extinction and emission of a piece at the ray parameter s.
struct Values {
  double extinction = 0;
  Rgb emission = Rgb::Zero();
};

Values valuesAt(const Piece& piece, double s) {
  const double u = s - piece.begin;
  const double fade = std::exp(-piece.decay * u);
  return {piece.extinction(u) * fade,
          Rgb(piece.emission[0](u), piece.emission[1](u), piece.emission[2](u)) * fade};
}

Values valuesAt(std::span<const Piece> pieces, double s) {
  for (const Piece& piece : pieces) {
    if (s >= piece.begin && s <= piece.end)
      return valuesAt(piece, s);
  }
  return {};
}

/// Some parameters well inside a piece.
std::vector<double> parametersInside(const Piece& piece) {
  const double length = std::isfinite(piece.end) ? piece.end - piece.begin
                        : piece.decay > 0        ? 5 / piece.decay
                                                 : 1;
  std::vector<double> out;
  for (double share : {0.07, 0.31, 0.5, 0.83}) out.push_back(piece.begin + share * length);
  return out;
}

bool isFinite(const Polynomial& curve) {
  for (double c : curve.c) {
    if (!std::isfinite(c))
      return false;
  }
  return true;
}

Failures piecesAreOrderedAndFinite(const MediumUnderTest& tested) {
  Report report;
  for (const NamedSegment& named : segmentsOf(tested)) {
    const auto pieces = piecesOf(tested.medium, named.segment);
    double last = named.segment.begin;
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      const Piece& piece = pieces[i];
      if (!(std::isfinite(piece.begin) && piece.begin < piece.end)) {
        report.at(named, "piece {} is from {} to {}", i, piece.begin, piece.end);
      }
      // One rounding of a border may differ between neighbours.
      const double slack = 1e-12 * std::max(std::abs(last), tested.traits.region.size().norm());
      if (!(piece.begin >= last - (i > 0 ? slack : 0))) {
        report.at(named, "piece {} begins at {}, before {}", i, piece.begin, last);
      }
      last = piece.end;
      const bool finite = isFinite(piece.extinction) && isFinite(piece.emission[0]) &&
                          isFinite(piece.emission[1]) && isFinite(piece.emission[2]) &&
                          std::isfinite(piece.decay);
      if (!finite)
        report.at(named, "piece {} has a coefficient that is not finite", i);
    }
    if (!(pieces.empty() || last <= named.segment.end))
      report.at(named, "the last piece ends at {}", last);
  }
  return report.take();
}

Failures emptyAndMissingSegmentsHaveNoPieces(const MediumUnderTest& tested) {
  Report report;
  for (const NamedSegment& named : emptySegmentsOf(tested)) {
    const auto pieces = piecesOf(tested.medium, named.segment);
    if (!pieces.empty())
      report.at(named, "{} pieces", pieces.size());
  }
  for (const NamedSegment& named : missingSegmentsOf(tested)) {
    const auto pieces = piecesOf(tested.medium, named.segment);
    if (!pieces.empty())
      report.at(named, "{} pieces", pieces.size());
  }
  return report.take();
}

Failures piecesAddUpToTheDepth(const MediumUnderTest& tested) {
  Report report;
  const Scale scale = scaleOf(tested);
  for (const NamedSegment& named : segmentsOf(tested)) {
    double sum = 0;
    for (const Piece& piece : piecesOf(tested.medium, named.segment))
      sum += pieceOpticalDepth(piece);
    const double depth = depthOf(tested.medium, named.segment);
    if (!near(sum, depth, tested.traits.tolerance.closedForm, scale.depth)) {
      report.at(named, "optical depth {:.17g}, but its pieces have {:.17g}", depth, sum);
    }
  }
  return report.take();
}

Failures piecesHaveThePointValues(const MediumUnderTest& tested) {
  Report report;
  const Scale scale = scaleOf(tested);
  const double tolerance = tested.traits.tolerance.points;
  for (const NamedSegment& named : genericSegmentsOf(tested)) {
    for (const Piece& piece : piecesOf(tested.medium, named.segment)) {
      if (piece.end - piece.begin < 1e-7 * scale.length)
        continue;  // a point in so thin a piece may round out of it
      for (double s : parametersInside(piece)) {
        const Values values = valuesAt(piece, s);
        const double extinction = tested.medium.extinction(named.segment.at(s));
        const Rgb emission = tested.medium.emission(named.segment.at(s));
        if (!near(values.extinction, extinction, tolerance, scale.extinctionAtPoints)) {
          report.at(named, "at {} the piece has extinction {:.12g}, the point {:.12g}", s,
                    values.extinction, extinction);
        }
        if (!near(values.emission, emission, tolerance, scale.emissionAtPoints)) {
          report.at(named, "at {} the piece has emission {}, the point {}", s,
                    text(values.emission), text(emission));
        }
      }
    }
  }
  return report.take();
}

Failures gapsAreEmptySpace(const MediumUnderTest& tested) {
  Report report;
  const Scale scale = scaleOf(tested);
  for (const NamedSegment& named : genericSegmentsOf(tested)) {
    const Interval inside = insideBounds(tested, named.segment);
    if (inside.empty())
      continue;
    double last = inside.begin;
    auto pieces = piecesOf(tested.medium, named.segment);
    pieces.push_back({inside.end, inside.end, {}, {}, 0});
    for (const Piece& piece : pieces) {
      if (std::isfinite(piece.begin - last) && piece.begin - last > 1e-7 * scale.length) {
        for (double share : {0.1, 0.5, 0.9}) {
          const double s = last + share * (piece.begin - last);
          const double extinction = tested.medium.extinction(named.segment.at(s));
          const Rgb emission = tested.medium.emission(named.segment.at(s));
          if (extinction != 0 || !(emission == 0).all()) {
            report.at(named, "no piece at {}, where the extinction is {} and the emission {}", s,
                      extinction, text(emission));
          }
        }
      }
      last = piece.end;
    }
  }
  return report.take();
}

Failures piecesMirrorBackwards(const MediumUnderTest& tested) {
  Report report;
  const Scale scale = scaleOf(tested);
  const double tolerance = tested.traits.tolerance.points;
  for (const NamedSegment& named : segmentsOf(tested)) {
    const auto pieces = piecesOf(tested.medium, named.segment);
    const auto mirrored = piecesOf(tested.medium, backwards(named.segment));
    const Rgb sum = emissionOf(pieces), mirroredSum = emissionOf(mirrored);
    if (!near(sum, mirroredSum, tested.traits.tolerance.closedForm, scale.emission)) {
      report.at(named, "the emission along it is {}, but {} backwards", text(sum),
                text(mirroredSum));
    }
    for (const Piece& piece : pieces) {
      if (piece.end - piece.begin < 1e-7 * scale.length)
        continue;
      for (double s : parametersInside(piece)) {
        const Values a = valuesAt(piece, s), b = valuesAt(mirrored, -s);
        if (!near(a.extinction, b.extinction, tolerance, scale.extinctionAtPoints) ||
            !near(a.emission, b.emission, tolerance, scale.emissionAtPoints)) {
          report.at(named, "at {} extinction {} and emission {}, but {} and {} backwards", s,
                    a.extinction, text(a.emission), b.extinction, text(b.emission));
        }
      }
    }
  }
  return report.take();
}

Failures splitPiecesAreTheSameCurve(const MediumUnderTest& tested) {
  Report report;
  const Scale scale = scaleOf(tested);
  const double tolerance = tested.traits.tolerance.points;
  Random random(tested.traits.seed + 7);
  for (const NamedSegment& named : segmentsOf(tested)) {
    const auto whole = piecesOf(tested.medium, named.segment);
    Segment back = named.segment;
    back.begin = parameterInside(tested, named.segment, random.uniform(0.1, 0.9));
    for (const Piece& piece : piecesOf(tested.medium, back)) {
      if (piece.begin < back.begin)
        report.at(named, "cut at {}, a piece begins at {}", back.begin, piece.begin);
      if (piece.end - piece.begin < 1e-7 * scale.length)
        continue;
      for (double s : parametersInside(piece)) {
        const Values a = valuesAt(piece, s), b = valuesAt(whole, s);
        if (!near(a.extinction, b.extinction, tolerance, scale.extinctionAtPoints) ||
            !near(a.emission, b.emission, tolerance, scale.emissionAtPoints)) {
          report.at(named, "at {} extinction {}, but {} when the segment begins at {}", s,
                    b.extinction, a.extinction, back.begin);
        }
      }
    }
  }
  return report.take();
}

Failures emissionAgreesWithQuadrature(const MediumUnderTest& tested) {
  Report report;
  const Scale scale = scaleOf(tested);
  const double tolerance = tested.traits.tolerance.quadrature;
  for (const NamedSegment& named : genericSegmentsOf(tested)) {
    const Rgb emission = emissionOf(piecesOf(tested.medium, named.segment));
    if (!emission.isFinite().all())
      continue;
    for (int channel = 0; channel < 3; ++channel) {
      const double byQuadrature = integralOfPoints(
          [&](const Vec3& point) { return tested.medium.emission(point)[channel]; },
          tested.medium.bounds(), named.segment, 0.01 * tolerance * scale.emission);
      if (!near(emission[channel], byQuadrature, tolerance, scale.emission)) {
        report.at(named,
                  "channel {} of the emission along it is {:.12g}, but quadrature at points gives "
                  "{:.12g}",
                  channel, emission[channel], byQuadrature);
      }
    }
  }
  return report.take();
}

}  // namespace

std::vector<Check> pieceChecks() {
  return {{"PiecesAreOrderedAndFinite", piecesAreOrderedAndFinite},
          {"EmptyAndMissingSegmentsHaveNoPieces", emptyAndMissingSegmentsHaveNoPieces},
          {"PiecesAddUpToTheDepth", piecesAddUpToTheDepth},
          {"PiecesHaveThePointValues", piecesHaveThePointValues},
          {"GapsAreEmptySpace", gapsAreEmptySpace},
          {"PiecesMirrorBackwards", piecesMirrorBackwards},
          {"SplitPiecesAreTheSameCurve", splitPiecesAreTheSameCurve},
          {"EmissionAgreesWithQuadrature", emissionAgreesWithQuadrature}};
}

}  // namespace volute::conformance
