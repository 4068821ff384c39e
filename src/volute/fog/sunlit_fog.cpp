// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fog/sunlit_fog.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "volute/fog/cell_spline.hpp"
#include "volute/medium/integrate.hpp"

namespace volute {
namespace {

constexpr double kLightTolerance = 1e-4;
constexpr double kFinestCut = 1 / 32.0;  // of a cell
constexpr double kThin = 0.125;          // optical depth of a step of radiance()
constexpr int kMaxSteps = 4096;          // in a cell, for rays that hardly ever leave it
constexpr double kLightLost = 1e-7;

/// curve * (a + b s + c s^2).
Polynomial timesParabola(const Polynomial& curve, double a, double b, double c) {
  Polynomial out = curve.timesLine(a, b);
  if (c != 0)
    out += curve.timesLine(0, 1).timesLine(0, c);
  return out;
}

using Shadows = std::vector<std::vector<Interval>>;  // of each sun

/// The ends of the parts of (begin, end) on which it is dark or light for each sun alike.
std::vector<double> edgesWithin(const Shadows& shadows, double begin, double end) {
  std::vector<double> edges;
  for (const auto& dark : shadows) {
    auto part = std::ranges::upper_bound(dark, begin, {}, &Interval::end);
    for (; part != dark.end() && part->begin < end; ++part) {
      for (double edge : {part->begin, part->end}) {
        if (edge > begin && edge < end)
          edges.push_back(edge);
      }
    }
  }
  std::ranges::sort(edges);
  edges.push_back(end);
  return edges;
}

bool isDark(std::span<const Interval> dark, double s) {
  const auto next = std::ranges::upper_bound(dark, s, {}, &Interval::begin);
  return next != dark.begin() && s < std::prev(next)->end;
}

/// Zero for the suns that do not reach the middle of a part.
std::vector<double> reaching(std::span<const double> phases, const Shadows& shadows, double begin,
                             double end) {
  std::vector<double> left(phases.begin(), phases.end());
  for (std::size_t i = 0; i < shadows.size(); ++i) {
    if (isDark(shadows[i], 0.5 * (begin + end)))
      left[i] = 0;
  }
  return left;
}

}  // namespace

Result<SunlitFog> SunlitFog::make(const FogMedium& fog, std::span<const Sun> suns,
                                  const SunScattering& scattering) {
  if (!(std::abs(scattering.asymmetry) < 1)) {
    return fail(ErrorCode::kInvalidArgument,
                "the asymmetry of fog is {}, but must be between -1 and 1", scattering.asymmetry);
  }
  if (!(scattering.albedo >= 0).all() || !(scattering.albedo <= 1).all())
    return fail(ErrorCode::kInvalidArgument, "the albedo of fog must be from 0 to 1");
  SunlitFog lit(fog);
  lit.scattering_ = scattering;
  for (const Sun& sun : suns) {
    if (!(sun.irradiance >= 0).all() || !sun.irradiance.isFinite().all())
      return fail(ErrorCode::kInvalidArgument,
                  "a sun's irradiance must be finite and not negative");
    VOLUTE_ASSIGN(SunShadow shadow, SunShadow::make(fog, sun.towards, scattering.samples));
    lit.suns_.push_back(sun);
    lit.shadows_.push_back(std::move(shadow));
  }
  return lit;
}

SunlitFog SunlitFog::withoutShadows() const {
  SunlitFog lit = *this;
  lit.scattering_.shadows = {};
  return lit;
}

std::vector<double> SunlitFog::phasesTowards(const Vec3& direction) const {
  std::vector<double> phases;
  // Light travels from the sun, and on against the ray.
  for (const SunShadow& shadow : shadows_)
    phases.push_back(henyeyGreenstein(scattering_.asymmetry, shadow.towardsSun().dot(direction)));
  return phases;
}

double SunlitFog::lit(const Vec3& point, std::size_t sun) const {
  return std::exp(-shadows_[sun].opticalDepth(point));
}

std::vector<std::vector<Interval>> SunlitFog::shadowsOn(const Segment& segment) const {
  if (!scattering_.shadows)
    return {};
  Shadows shadows(suns_.size());
  const Interval inside =
      bounds().intersect(segment.origin, segment.direction).intersect({segment.begin, segment.end});
  if (inside.empty())
    return shadows;
  const Segment part{segment.origin, segment.direction, inside.begin, inside.end};
  for (std::size_t i = 0; i < suns_.size(); ++i) scattering_.shadows(part, i, shadows[i]);
  return shadows;
}

Rgb SunlitFog::source(const Vec3& point, std::span<const double> phases) const {
  Rgb light = fog_.options().color;
  for (std::size_t i = 0; i < suns_.size(); ++i) {
    if (phases[i] > 0)
      light += scattering_.albedo * suns_[i].irradiance * (phases[i] * lit(point, i));
  }
  return light;
}

Rgb SunlitFog::emission(const Vec3& point) const {
  const std::vector<double> phases(suns_.size(), 1 / (4 * std::numbers::pi));
  return extinction(point) * source(point, phases);
}

void SunlitFog::cut(const Segment& segment, const Piece& piece, std::span<const double> phases,
                    std::vector<Piece>& out) const {
  const double length = piece.end - piece.begin;
  const auto at = [&](double share) {
    return source(segment.at(piece.begin + share * length), phases);
  };
  constexpr int kLitTerms = 8;  // more cost more than the cuts that they save
  const int room = kLitTerms - piece.extinction.terms();  // degrees that may be added
  const Rgb first = at(0), middle = at(0.5), last = at(1);
  // The light as a + b x + c x^2 with x from 0 to 1.
  const Rgb c = room >= 2 ? Rgb(2 * (first + last - 2 * middle)) : Rgb::Zero();
  const Rgb a = room >= 1 ? first : middle;
  const Rgb b = room >= 1 ? Rgb(last - first - c) : Rgb::Zero();
  double error = 0;
  for (double x : {0.25, 0.75}) {
    const Rgb there = at(x);
    error = std::max(error, ((a + b * x + c * x * x - there).abs()).maxCoeff() -
                                kLightTolerance * there.maxCoeff());
  }
  if (error > 0 && length > kFinestCut * fog_.cell()) {
    const double half = piece.begin + 0.5 * length;
    cut(segment, clipped(piece, piece.begin, half), phases, out);
    cut(segment, clipped(piece, half, piece.end), phases, out);
    return;
  }
  Piece lit = piece;
  for (int k = 0; k < 3; ++k) {
    lit.emission[k] =
        timesParabola(piece.extinction, a[k], b[k] / length, c[k] / (length * length));
  }
  out.push_back(lit);
}

void SunlitFog::pieces(std::span<const Segment> segments,
                       std::span<std::vector<Piece>> pieces) const {
  std::vector<Piece> plain;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    pieces[i].clear();
    fog_.pieces(segments.subspan(i, 1), {&plain, 1});
    const std::vector<double> phases = phasesTowards(segments[i].direction);
    const Shadows shadows = shadowsOn(segments[i]);
    for (const Piece& piece : plain) {
      double from = piece.begin;
      for (double to : edgesWithin(shadows, piece.begin, piece.end)) {
        cut(segments[i], clipped(piece, from, to), reaching(phases, shadows, from, to), pieces[i]);
        from = to;
      }
    }
  }
}

/// The cells that rays side by side have met: most are in here for all but the first of them.
class SunlitFog::Cells {
 public:
  explicit Cells(const FogMedium& fog) : fog_(fog), kept_(kPlaces) {}

  const CellSpline& at(int level, int x, int y) {
    const auto place = static_cast<std::size_t>(x + 37 * y + 101 * level) % kPlaces;
    std::optional<Kept>& kept = kept_[place];
    if (!kept || kept->level != level || kept->x != x || kept->y != y) {
      kept.emplace(
          Kept{level, x, y,
               CellSpline(fog_.levels().pyramid().level(level), fog_.options().degree, x, y)});
    }
    return kept->cell;
  }

 private:
  static constexpr std::size_t kPlaces = 256;

  struct Kept {
    int level, x, y;
    CellSpline cell;
  };

  const FogMedium& fog_;
  std::vector<std::optional<Kept>> kept_;
};

std::vector<double> SunlitFog::sunlight(const Segment& segment, Cells& cells) const {
  std::vector<double> light(suns_.size());
  if (suns_.empty())
    return light;
  const double nodes[2] = {0.5 - 0.5 / std::sqrt(3.0), 0.5 + 0.5 / std::sqrt(3.0)};
  const double bottom = segment.origin.z() - fog_.domainCorner().z();
  const std::vector<double> phases = phasesTowards(segment.direction);
  const Shadows shadows = shadowsOn(segment);
  double passed = 1;
  std::vector<FogMedium::Stretch> parts;
  fog_.stretches(segment, parts);
  for (const auto& part : parts) {
    const PlaneRay ray = fog_.planeRay(segment, part.level);
    const PlaneAxis alongX{ray.ox, ray.dx}, alongY{ray.oy, ray.dy};
    const auto inCell = [&](int x, int y, double begin, double end) {
      if (passed < kLightLost)
        return;
      const CellSpline& cell = cells.at(part.level, x, y);
      if (cell.largest() == 0)
        return;
      const double step = std::min(fog_.cell(), kThin / cell.largest());
      const auto inSteps = [&](double from, double to, std::span<const double> reach) {
        const int steps =
            std::clamp(static_cast<int>(std::min((to - from) / step, 1e6)) + 1, 1, kMaxSteps);
        const double length = (to - from) / steps;
        for (int k = 0; k < steps && passed >= kLightLost; ++k) {
          double depth = 0;
          for (double node : nodes) {
            const double s = from + (k + node) * length;
            depth += 0.5 * length * cell(alongX.at(s) - x, alongY.at(s) - y) *
                     (*part.zone)(bottom + s * segment.direction.z());
          }
          const double after = passed * std::exp(-depth);
          const Vec3 middle = segment.at(from + (k + 0.5) * length);
          for (std::size_t i = 0; i < light.size(); ++i) {
            if (reach[i] > 0)
              light[i] += (passed - after) * reach[i] * lit(middle, i);
          }
          passed = after;
        }
      };
      if (shadows.empty())
        return inSteps(begin, end, phases);
      double from = begin;
      for (double to : edgesWithin(shadows, begin, end)) {
        inSteps(from, to, reaching(phases, shadows, from, to));
        from = to;
      }
    };
    walkCells(ray, fog_.levels().level(part.level).occupied, part.begin, part.end, inCell);
  }
  return light;
}

void SunlitFog::radiance(std::span<const Segment> segments, std::span<Radiance> out) const {
  fog_.radiance(segments, out);
  Cells cells(fog_);
  for (std::size_t k = 0; k < segments.size(); ++k) {
    const std::vector<double> light = sunlight(segments[k], cells);
    for (std::size_t i = 0; i < suns_.size(); ++i)
      out[k].emitted += scattering_.albedo * suns_[i].irradiance * light[i];
  }
}

}  // namespace volute
