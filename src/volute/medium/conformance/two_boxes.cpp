// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>
#include <cmath>

#include "volute/math/quadrature.hpp"
#include "volute/medium/conformance/dummy_media.hpp"

namespace volute::conformance {

const Box3 TwoBoxes::kFirst{Vec3(0, 0, 0), Vec3(1, 2, 1)};
const Box3 TwoBoxes::kSecond{Vec3(2, 0.5, 0), Vec3(3.5, 2, 1)};

namespace {

const Rgb kBoxColour(3, 1, 0.25);  ///< emission [radiance/m] per extinction [1/m] in the first box
const Rgb kGlow(0.5, 0.1, 2);      ///< emission [radiance/m] of the second, even

struct Inside {
  int box;
  Interval interval;
};

std::vector<Inside> inside(const Segment& segment) {
  std::vector<Inside> out;
  for (int box : {0, 1}) {
    const Box3& bounds = box == 0 ? TwoBoxes::kFirst : TwoBoxes::kSecond;
    const Interval interval =
        bounds.intersect(segment.origin, segment.direction).intersect({segment.begin, segment.end});
    if (!interval.empty())
      out.push_back({box, interval});
  }
  std::sort(out.begin(), out.end(),
            [](const Inside& a, const Inside& b) { return a.interval.begin < b.interval.begin; });
  return out;
}

/// How far across the second box a coordinate is, from 0 to 1.
double across(double x) {
  return (x - TwoBoxes::kSecond.min.x()) / TwoBoxes::kSecond.size().x();
}

/// Lengths through the basis functions, in the order of the coefficients; linear functions by their
/// middle.
std::array<double, 3> basisIntegrals(const Segment& segment) {
  std::array<double, 3> out{};
  for (const auto& [box, interval] : inside(segment)) {
    if (box == 0) {
      out[0] += interval.length();
      continue;
    }
    const double t = across(segment.at(0.5 * (interval.begin + interval.end)).x());
    out[1] += (1 - t) * interval.length();
    out[2] += t * interval.length();
  }
  return out;
}

}  // namespace

Box3 TwoBoxes::bounds() const {
  return {kFirst.min.cwiseMin(kSecond.min), kFirst.max.cwiseMax(kSecond.max)};
}

double TwoBoxes::extinction(const Vec3& point) const {
  if (kFirst.contains(point))
    return c_[0];
  if (!kSecond.contains(point))
    return 0;
  return c_[1] + (c_[2] - c_[1]) * across(point.x());
}

Rgb TwoBoxes::emission(const Vec3& point) const {
  if (kFirst.contains(point))
    return kBoxColour * c_[0];
  return kSecond.contains(point) ? kGlow : Rgb(Rgb::Zero());
}

void TwoBoxes::opticalDepth(std::span<const Segment> segments, std::span<double> depths) const {
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const auto basis = basisIntegrals(segments[i]);
    depths[i] = c_[0] * basis[0] + c_[1] * basis[1] + c_[2] * basis[2];
  }
}

void TwoBoxes::pieces(std::span<const Segment> segments,
                      std::span<std::vector<Piece>> pieces) const {
  for (std::size_t i = 0; i < segments.size(); ++i) {
    pieces[i].clear();
    for (const auto& [box, interval] : inside(segments[i])) {
      Piece piece{interval.begin, interval.end, {}, {}, 0};
      const double slope = segments[i].direction.x() / kSecond.size().x() * (c_[2] - c_[1]);
      const double start = c_[1] + (c_[2] - c_[1]) * across(segments[i].at(interval.begin).x());
      piece.extinction = box == 0 ? Cubic{{c_[0], 0, 0, 0}} : Cubic{{start, slope, 0, 0}};
      for (int channel = 0; channel < 3; ++channel) {
        piece.emission[channel].c[0] = box == 0 ? kBoxColour[channel] * c_[0] : kGlow[channel];
      }
      pieces[i].push_back(piece);
    }
  }
}

/// As a fast path would, without pieces: the closed form in the first box, in the second a Gauss
/// rule over the transmittance, whose exponent is a parabola.
void TwoBoxes::radiance(std::span<const Segment> segments, std::span<Radiance> out) const {
  for (std::size_t i = 0; i < segments.size(); ++i) {
    out[i] = {};
    for (const auto& [box, interval] : inside(segments[i])) {
      const double length = interval.length();
      const double slope = segments[i].direction.x() / kSecond.size().x() * (c_[2] - c_[1]);
      const double start = c_[1] + (c_[2] - c_[1]) * across(segments[i].at(interval.begin).x());
      const auto depth = [&](double u) {
        return box == 0 ? c_[0] * u : u * (start + 0.5 * slope * u);
      };
      if (box == 0) {
        out[i].emitted += out[i].transmittance * -std::expm1(-depth(length)) * kBoxColour;
      } else {
        const double seen =
            gaussIntegral(8, 0.0, length, [&](double u) { return std::exp(-depth(u)); });
        out[i].emitted += out[i].transmittance * seen * kGlow;
      }
      out[i].transmittance *= std::exp(-depth(length));
    }
  }
}

Traits traitsOf(const TwoBoxes&) {
  Traits traits;
  for (int axis = 0; axis < 3; ++axis) {
    for (const Box3* box : {&TwoBoxes::kFirst, &TwoBoxes::kSecond}) {
      traits.planes[axis].insert(traits.planes[axis].end(), {box->min[axis], box->max[axis]});
    }
  }
  return traits;
}

MediumUnderTest twoBoxesUnderTest() {
  const TwoBoxes boxes({0.8, 0.3, 2.0});
  return underTest(boxes, traitsOf(boxes));
}

}  // namespace volute::conformance
