// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>
#include <atomic>
#include <limits>

#include "volute/base/parallel.hpp"
#include "volute/medium/conformance/support.hpp"

// How the calls behave, whatever they compute: batches, outputs, threads. All compare bit for bit.

namespace volute::conformance {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// All kinds in one batch, each twice, so that neighbours are as different as can be.
std::vector<NamedSegment> mixedSegmentsOf(const MediumUnderTest& tested) {
  std::vector<NamedSegment> mixed;
  const auto missing = missingSegmentsOf(tested), empty = emptySegmentsOf(tested);
  std::size_t i = 0;
  for (const NamedSegment& named : segmentsOf(tested)) {
    mixed.push_back(named);
    if (i < missing.size())
      mixed.push_back(missing[i]);
    if (i < empty.size())
      mixed.push_back(empty[i]);
    ++i;
  }
  const std::vector<NamedSegment> reversed(mixed.rbegin(), mixed.rend());
  mixed.insert(mixed.end(), reversed.begin(), reversed.end());
  return mixed;
}

bool same(double a, double b) {
  return a == b || (a != a && b != b);
}

bool same(const Piece& a, const Piece& b) {
  return a.begin == b.begin && a.end == b.end && a.decay == b.decay &&
         a.extinction.c == b.extinction.c && a.emission[0].c == b.emission[0].c &&
         a.emission[1].c == b.emission[1].c && a.emission[2].c == b.emission[2].c;
}

bool same(const std::vector<Piece>& a, const std::vector<Piece>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const Piece& p, const Piece& q) { return same(p, q); });
}

Failures depthsInABatchAreThoseAlone(const MediumUnderTest& tested) {
  Report report;
  const auto segments = mixedSegmentsOf(tested);
  std::vector<double> depths(segments.size(), kNan);  // what is not overwritten shows
  tested.medium.opticalDepth(batchOf(segments), depths);
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const double alone = depthOf(tested.medium, segments[i].segment);
    if (!(depths[i] == alone))
      report.at(segments[i], "optical depth {} in a batch, {} alone", depths[i], alone);
  }
  return report.take();
}

Failures piecesInABatchAreThoseAlone(const MediumUnderTest& tested) {
  Report report;
  const auto segments = mixedSegmentsOf(tested);
  std::vector<std::vector<Piece>> pieces(segments.size());
  tested.medium.pieces(batchOf(segments), pieces);
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const auto alone = piecesOf(tested.medium, segments[i].segment);
    if (!same(pieces[i], alone)) {
      report.at(segments[i], "its {} pieces in a batch are not its {} pieces alone",
                pieces[i].size(), alone.size());
    }
  }
  return report.take();
}

Failures radiancesInABatchAreThoseAlone(const MediumUnderTest& tested) {
  Report report;
  const auto segments = mixedSegmentsOf(tested);
  std::vector<Radiance> radiances(segments.size(), Radiance{Rgb::Constant(kNan), kNan});
  tested.medium.radiance(batchOf(segments), radiances);
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const Radiance alone = radianceOf(tested.medium, segments[i].segment);
    if (!(radiances[i].emitted == alone.emitted).all() ||
        radiances[i].transmittance != alone.transmittance) {
      report.at(segments[i], "radiance {} in a batch, {} alone", text(radiances[i].emitted),
                text(alone.emitted));
    }
  }
  return report.take();
}

Failures piecesReplaceWhatWasThere(const MediumUnderTest& tested) {
  Report report;
  const auto segments = mixedSegmentsOf(tested);
  std::vector<std::vector<Piece>> pieces(segments.size(), std::vector<Piece>(3));
  tested.medium.pieces(batchOf(segments), pieces);
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const auto fresh = piecesOf(tested.medium, segments[i].segment);
    if (!same(pieces[i], fresh)) {
      report.at(segments[i], "{} pieces where three old ones stood, {} into an empty list",
                pieces[i].size(), fresh.size());
    }
  }
  return report.take();
}

Failures depthsReplaceWhatWasThere(const MediumUnderTest& tested) {
  Report report;
  for (const NamedSegment& named : mixedSegmentsOf(tested)) {
    double depth = 12345;
    tested.medium.opticalDepth({&named.segment, 1}, {&depth, 1});
    const double fresh = depthOf(tested.medium, named.segment);
    if (depth != fresh)
      report.at(named, "optical depth {} where 12345 stood, {} where nothing did", depth, fresh);
  }
  return report.take();
}

Failures emptyBatchesDoNothing(const MediumUnderTest& tested) {
  tested.medium.opticalDepth({}, {});
  tested.medium.pieces({}, {});
  tested.medium.radiance({}, {});
  return {};
}

Failures threadsAgree(const MediumUnderTest& tested) {
  const auto segments = mixedSegmentsOf(tested);
  const auto batch = batchOf(segments);
  std::vector<double> expected(batch.size());
  std::vector<std::vector<Piece>> expectedPieces(batch.size());
  tested.medium.opticalDepth(batch, expected);
  tested.medium.pieces(batch, expectedPieces);
  std::atomic<int> wrong = 0;
  parallelFor(8, [&](std::size_t) {
    std::vector<double> depths(batch.size());
    std::vector<std::vector<Piece>> pieces(batch.size());
    tested.medium.opticalDepth(batch, depths);
    tested.medium.pieces(batch, pieces);
    for (std::size_t i = 0; i < batch.size(); ++i) {
      if (!same(depths[i], expected[i]) || !same(pieces[i], expectedPieces[i]))
        ++wrong;
    }
  });
  Report report;
  if (wrong > 0)
    report.add("{} answers to concurrent calls differ from those of a single thread", wrong.load());
  return report.take();
}

Failures anyMediumAnswersAsTheMedium(const MediumUnderTest& tested) {
  Report report;
  for (const NamedSegment& named : mixedSegmentsOf(tested)) {
    double depth = kNan;
    std::vector<Piece> pieces;
    tested.directDepth({&named.segment, 1}, {&depth, 1});
    tested.directPieces({&named.segment, 1}, {&pieces, 1});
    if (!same(depth, depthOf(tested.medium, named.segment)) ||
        !same(pieces, piecesOf(tested.medium, named.segment))) {
      report.at(named, "AnyMedium answers differently from the medium itself");
    }
  }
  return report.take();
}

}  // namespace

std::vector<Check> callChecks() {
  return {{"EmptyBatchesDoNothing", emptyBatchesDoNothing},
          {"DepthsInABatchAreThoseAlone", depthsInABatchAreThoseAlone},
          {"PiecesInABatchAreThoseAlone", piecesInABatchAreThoseAlone},
          {"RadiancesInABatchAreThoseAlone", radiancesInABatchAreThoseAlone},
          {"DepthsReplaceWhatWasThere", depthsReplaceWhatWasThere},
          {"PiecesReplaceWhatWasThere", piecesReplaceWhatWasThere},
          {"ThreadsAgree", threadsAgree},
          {"AnyMediumAnswersAsTheMedium", anyMediumAnswersAsTheMedium}};
}

}  // namespace volute::conformance
