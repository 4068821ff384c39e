// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>
#include <string>
#include <vector>

#include "volute/medium/conformance_checks.hpp"

// Segments of every awkward kind.

namespace volute::conformance {

/// A segment and what is special about it.
struct NamedSegment {
  std::string what;
  Segment segment;
  /// For a segment along a face or an edge, where the answer may be that of either side: unit
  /// vectors towards the sides. Empty for all others, whose answer is unique.
  std::vector<Vec3> sides{};
};

/// Segments that are not empty: random ones, from inside, infinite ones, parallel to axes, along
/// faces and edges.
std::vector<NamedSegment> segmentsOf(const MediumUnderTest& tested);

/// Those of segmentsOf() that lie along no face or edge.
std::vector<NamedSegment> genericSegmentsOf(const MediumUnderTest& tested);

std::vector<NamedSegment> emptySegmentsOf(const MediumUnderTest& tested);

/// Segments that pass the bounds by.
std::vector<NamedSegment> missingSegmentsOf(const MediumUnderTest& tested);

/// The plain segments, to be handed over as one batch.
std::vector<Segment> batchOf(std::span<const NamedSegment> segments);

}  // namespace volute::conformance
