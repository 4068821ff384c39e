// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <fmt/format.h>

#include "volute/medium/conformance/segments.hpp"
#include "volute/medium/conformance_checks.hpp"

// What the checks share: a medium asked about one segment, what is near, and reports that a person
// can act on.

namespace volute::conformance {

/// The interval of a segment inside of the bounds.
Interval insideBounds(const MediumUnderTest& tested, const Segment& segment);

/// The same points the other way: s becomes -s.
Segment backwards(const Segment& segment);

/// A parameter strictly between the ends, inside the bounds where the segment is. `share` in (0,
/// 1).
double parameterInside(const MediumUnderTest& tested, const Segment& segment, double share);

// The calls of the medium for one segment alone.
double depthOf(const AnyMedium& medium, const Segment& segment);
std::vector<Piece> piecesOf(const AnyMedium& medium, const Segment& segment);
Radiance radianceOf(const AnyMedium& medium, const Segment& segment);
Rgb emissionOf(std::span<const Piece> pieces);

/// Typical sizes of the medium's answers over its segments; 1 where all are zero. What "near" is
/// measured by.
struct Scale {
  double length = 1;  ///< [m], the diagonal of the region
  double depth = 1;
  double emission = 1;  ///< of the emission integral
  double extinctionAtPoints = 1;
  double emissionAtPoints = 1;
};

Scale scaleOf(const MediumUnderTest& tested);

/// |a - b| <= relative * max(|a|, |b|, scale); equal infinities are near, NaN is near nothing.
bool near(double a, double b, double relative, double scale);
bool near(const Rgb& a, const Rgb& b, double relative, double scale);

/// The emitted radiance against the scale of the emission, the transmittance against 1.
bool near(const Radiance& a, const Radiance& b, double relative, const Scale& scale);

std::string text(const Segment& segment);
std::string text(const Rgb& rgb);
std::string text(const Radiance& radiance);

/// Collects sentences and keeps the first few.
class Report {
 public:
  template <class... Args>
  void add(fmt::format_string<Args...> format, Args&&... args) {
    if (++count_ <= kShown)
      failures_.push_back(fmt::format(format, std::forward<Args>(args)...));
  }

  /// The same, about a segment.
  template <class... Args>
  void at(const NamedSegment& segment, fmt::format_string<Args...> format, Args&&... args) {
    add("{}: {}; segment {}", segment.what, fmt::format(format, std::forward<Args>(args)...),
        text(segment.segment));
  }

  Failures take();

 private:
  static constexpr std::size_t kShown = 4;
  std::size_t count_ = 0;
  Failures failures_;
};

// One list for each group; checks() joins them.
std::vector<Check> depthChecks();
std::vector<Check> pieceChecks();
std::vector<Check> radianceChecks();
std::vector<Check> callChecks();
std::vector<Check> linearChecks();

}  // namespace volute::conformance
