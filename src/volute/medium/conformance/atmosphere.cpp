// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <cmath>
#include <limits>

#include "volute/medium/conformance/dummy_media.hpp"

namespace volute::conformance {
namespace {

constexpr double kNoEnd = std::numeric_limits<double>::infinity();
constexpr double kWidth = 20;  ///< [m], along x and y
constexpr double kTop = 60;  ///< in scale heights: exp(-60) of the fog is above, too little to tell
const Rgb kColour(0.9, 0.5, 0.2);

/// 1 on the left face, 2 on the right one.
double glow(double x) {
  return 1 + x / kWidth;
}

/// The even part of a piece: the profile at its begin and its decay along it.
struct Stretch {
  double begin, end;
  double profile;
  double decay;
};

/// Below and above the bottom of the thinning, from front to back.
std::vector<Stretch> stretches(const Segment& segment, const Box3& bounds) {
  const Interval inside =
      bounds.intersect(segment.origin, segment.direction).intersect({segment.begin, segment.end});
  const double rise = segment.direction.z();
  const auto height = [&](double s) { return segment.origin.z() + s * rise - Atmosphere::kBottom; };
  const auto above = [&](Interval part) -> std::vector<Stretch> {
    // Coming down from infinity, it begins where there is something.
    const double top = kTop * Atmosphere::kScaleHeight;
    if (rise < 0)
      part.begin = std::max(part.begin, (top + Atmosphere::kBottom - segment.origin.z()) / rise);
    if (part.empty())
      return {};
    const double profile = std::exp(-height(part.begin) / Atmosphere::kScaleHeight);
    return {{part.begin, part.end, profile, rise / Atmosphere::kScaleHeight}};
  };
  const auto below = [&](Interval part) -> std::vector<Stretch> {
    return part.empty() ? std::vector<Stretch>{}
                        : std::vector<Stretch>{{part.begin, part.end, 1, 0}};
  };
  if (inside.empty())
    return {};
  if (rise == 0)
    return height(0) > 0 ? above(inside) : below(inside);

  const double border = -height(0) / rise;
  const Interval front{inside.begin, std::min(border, inside.end)},
      back{std::max(border, inside.begin), inside.end};
  std::vector<Stretch> out = rise > 0 ? below(front) : above(front);
  for (const Stretch& stretch : rise > 0 ? above(back) : below(back)) out.push_back(stretch);
  return out;
}

double integral(const Stretch& stretch) {
  return decayingIntegral(Cubic{{stretch.profile, 0, 0, 0}}, stretch.decay,
                          stretch.end - stretch.begin);
}

}  // namespace

Box3 Atmosphere::bounds() const {
  return {Vec3(0, 0, 0), Vec3(kWidth, kWidth, kNoEnd)};
}

double Atmosphere::profile(const Vec3& point) const {
  if (!bounds().contains(point))
    return 0;
  return std::exp(-std::max(point.z() - kBottom, 0.0) / kScaleHeight);
}

Rgb Atmosphere::emission(const Vec3& point) const {
  return kColour * (profile(point) * glow(point.x()));
}

void Atmosphere::opticalDepth(std::span<const Segment> segments, std::span<double> depths) const {
  for (std::size_t i = 0; i < segments.size(); ++i) {
    depths[i] = 0;
    for (const Stretch& stretch : stretches(segments[i], bounds()))
      depths[i] += ground_ * integral(stretch);
  }
}

void Atmosphere::pieces(std::span<const Segment> segments,
                        std::span<std::vector<Piece>> pieces) const {
  for (std::size_t i = 0; i < segments.size(); ++i) {
    pieces[i].clear();
    for (const Stretch& stretch : stretches(segments[i], bounds())) {
      Piece piece{stretch.begin,
                  stretch.end,
                  Cubic{{ground_ * stretch.profile, 0, 0, 0}},
                  {},
                  stretch.decay};
      const double x = segments[i].at(stretch.begin).x();
      for (int channel = 0; channel < 3; ++channel) {
        const Cubic curve{{glow(x), segments[i].direction.x() / kWidth, 0, 0}};
        piece.emission[channel] = curve * (kColour[channel] * stretch.profile);
      }
      pieces[i].push_back(piece);
    }
  }
}

Traits traitsOf(const Atmosphere&) {
  return {.planes = {{{}, {}, {Atmosphere::kBottom}}},
          .region = {Vec3(0, 0, 0), Vec3(kWidth, kWidth, 5 * Atmosphere::kScaleHeight)}};
}

MediumUnderTest atmosphereUnderTest() {
  const Atmosphere atmosphere(0.2);
  return underTest(atmosphere, traitsOf(atmosphere));
}

}  // namespace volute::conformance
