// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors

// The one thing that Volute does, with the smallest possible medium: a ball of uniform, glowing
// smoke.

#include <fmt/core.h>

#include <cmath>

#include "volute/medium/any_medium.hpp"

using namespace volute;

struct Ball {
  double radius, sigma;  // [m], [1/m]: its one coefficient
  Rgb glow;              // [radiance/m]

  Box3 bounds() const { return {Vec3::Constant(-radius), Vec3::Constant(radius)}; }

  double extinction(const Vec3& point) const { return point.norm() <= radius ? sigma : 0; }

  Rgb emission(const Vec3& point) const { return point.norm() <= radius ? glow : Rgb::Zero(); }

  Interval chord(const Segment& s) const {
    const double middle = -s.origin.dot(s.direction);
    const double half2 = radius * radius - s.at(middle).squaredNorm();
    if (half2 <= 0)
      return {};
    return Interval{middle - std::sqrt(half2), middle + std::sqrt(half2)}.intersect(
        {s.begin, s.end});
  }

  void opticalDepth(std::span<const Segment> segments, std::span<double> depths) const {
    for (std::size_t i = 0; i < segments.size(); ++i) {
      depths[i] = sigma * chord(segments[i]).length();
    }
  }

  void pieces(std::span<const Segment> segments, std::span<std::vector<Piece>> pieces) const {
    for (std::size_t i = 0; i < segments.size(); ++i) {
      pieces[i].clear();
      const Interval c = chord(segments[i]);
      const Polynomial emission[3]{{{glow[0]}}, {{glow[1]}}, {{glow[2]}}};
      if (!c.empty()) {
        pieces[i].push_back(
            {c.begin, c.end, {{sigma}}, {emission[0], emission[1], emission[2]}, 0});
      }
    }
  }
};

int main() {
  const AnyMedium medium(Ball{1.0, 0.5, Rgb(2, 1, 0.2)});
  const Segment segment{Vec3(-5, 0, 0), Vec3::UnitX(), 0, 20};  // 20 m along x

  double depth = 0;
  Radiance radiance;
  medium.opticalDepth({&segment, 1}, {&depth, 1});
  medium.radiance({&segment, 1}, {&radiance, 1});

  fmt::print("optical depth {:.3f}, transmittance {:.3f}, emitted {:.3f} {:.3f} {:.3f}\n", depth,
             radiance.transmittance, radiance.emitted[0], radiance.emitted[1], radiance.emitted[2]);
}
