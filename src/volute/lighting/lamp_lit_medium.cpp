// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/lighting/lamp_lit_medium.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "volute/base/parallel.hpp"
#include "volute/math/phase_function.hpp"
#include "volute/math/quadrature.hpp"
#include "volute/medium/integrate.hpp"

namespace volute {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kAcross = 32, kUp = 16;  ///< directions around the vertical, and up
constexpr int kDistances = 32;
constexpr double kFarther = 1.35;  ///< each is at as many times the one before
constexpr double kNothing = 1e-7;  ///< of a lamp's light
constexpr double kAfar = 4;        ///< spreads away lamps are one
constexpr std::size_t kMaxLamps = 3;
constexpr double kTolerance = 1e-3;
constexpr int kMaxCuts = 12;
constexpr double kGone = 30;  ///< e-folds after which nothing is left

double roughAngle(double x, double y);

}  // namespace

/// A lamp, and what its light meets on its ways.
struct LampLitMedium::Light {
  /// Up to a place: the optical depth, and whether nothing opaque was met.
  struct Way {
    float depth = 0, open = 1;
  };

  Lamp lamp;
  std::vector<Way> ways;  ///< shape (kUp + 1, kAcross, kDistances)

  double distanceOf(int i) const {
    static const auto kPowers = [] {
      std::array<double, kDistances> powers;
      for (int k = 0; k < kDistances; ++k)
        powers[static_cast<std::size_t>(k)] = std::pow(kFarther, k);
      return powers;
    }();
    return lamp.radius * kPowers[static_cast<std::size_t>(i)];
  }

  double shareAt(const Vec3& point) const {
    const Vec3 away = point - lamp.position;
    const double far = away.norm();
    if (!(far > 0))
      return 1;
    const double up = (1 - std::clamp(away.z() / far, -1.0, 1.0)) / 2 * kUp;
    const double round = (roughAngle(away.x(), away.y()) / (2 * kPi) + 1) * kAcross;
    const double out =
        std::clamp(std::log(far / lamp.radius) / std::log(kFarther), 0.0, kDistances - 1.0);
    const int i = std::min(static_cast<int>(up), kUp - 1), j = static_cast<int>(round);
    const int k = std::min(static_cast<int>(out), kDistances - 2);
    const double u = up - i, v = round - j;
    const double near = distanceOf(k);
    const double w = std::clamp((far - near) / (distanceOf(k + 1) - near), 0.0, 1.0);
    double depth = 0, open = 0;
    const auto add = [&](int row, int column, double share) {
      const Way* from =
          &ways[static_cast<std::size_t>((row * kAcross + column % kAcross) * kDistances + k)];
      depth += share * ((1 - w) * static_cast<double>(from[0].depth) +
                        w * static_cast<double>(from[1].depth));
      open += share *
              ((1 - w) * static_cast<double>(from[0].open) + w * static_cast<double>(from[1].open));
    };
    add(i, j, (1 - u) * (1 - v)), add(i, j + 1, (1 - u) * v);
    add(i + 1, j, u * (1 - v)), add(i + 1, j + 1, u * v);
    return open * std::exp(-depth);
  }

  void spread(const AnyMedium& medium, const LampScattering& scattering) {
    ways.assign(static_cast<std::size_t>(kUp + 1) * kAcross * kDistances, {});
    parallelFor(static_cast<std::size_t>(kUp + 1) * kAcross, [&](std::size_t way) {
      const double z = 1 - 2 * static_cast<double>(way / kAcross) / kUp, r = std::sqrt(1 - z * z);
      const double round = 2 * kPi * (static_cast<double>(way % kAcross) / kAcross - 1);
      const Vec3 direction(r * std::cos(round), r * std::sin(round), z);
      std::vector<Segment> steps, back;
      double before = 0;
      for (int i = 0; i < kDistances; ++i) {
        const double far = distanceOf(i);
        steps.push_back({lamp.position, direction, before, far});
        back.push_back({lamp.position + far * direction, -direction, 0, far});
        before = far;
      }
      std::vector<double> sum(steps.size(), 0), depths(steps.size());
      const auto add = [&](const AnyMedium& one) {
        one.opticalDepth(steps, depths);
        for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += depths[i];
      };
      add(medium);
      for (const AnyMedium& other : scattering.between) add(other);
      std::vector<std::uint8_t> blocked(steps.size(), 0);
      if (scattering.blocks)
        scattering.blocks(back, blocked);
      double depth = 0;
      for (std::size_t i = 0; i < steps.size(); ++i) {
        depth += sum[i];
        ways[way * kDistances + i] = {static_cast<float>(depth), blocked[i] ? 0.0F : 1.0F};
      }
    });
  }
};

namespace {

/// Extinction, and the share of light that gets back to the begin, along pieces of a ray: the
/// optical depth as a cubic in each part of a piece, by its extinction at both ends and in the
/// middle.
class AlongRay {
 public:
  explicit AlongRay(std::span<const Piece> pieces) {
    parts_.reserve(pieces.size());
    for (const Piece& piece : pieces) {
      const double end = std::isfinite(piece.end) ? piece.end
                         : piece.decay > 0        ? piece.begin + kGone / piece.decay
                                                  : piece.begin;
      const double efolds = std::abs(piece.decay) * (end - piece.begin);
      const int count = static_cast<int>(std::clamp(std::ceil(efolds), 1.0, kGone));
      const double length = (end - piece.begin) / count;
      const auto at = [&](double u) { return piece.extinction(u) * std::exp(-piece.decay * u); };
      double first = at(0);
      for (int i = 0; i < count && length > 0; ++i) {
        const double begin = i * length, last = at(begin + length);
        const double depth = length / 6 * (first + 4 * at(begin + 0.5 * length) + last);
        parts_.push_back({piece.begin + begin, length, first, last, depth, depth_});
        depth_ += depth;
        first = last;
      }
    }
  }

  bool empty() const { return parts_.empty(); }

  double begin() const { return parts_.front().begin; }

  double end() const { return parts_.back().begin + parts_.back().length; }

  /// K exp(-t) at s.
  double at(double s) const {
    const auto after = std::ranges::upper_bound(parts_, s, {}, &Part::begin);
    if (after == parts_.begin())
      return 0;
    const Part& part = *(after - 1);
    const double u = (s - part.begin) / part.length;
    if (u > 1)
      return 0;
    // Hermite's cubic for the depth, and its slope.
    const double a = part.first * part.length, b = part.last * part.length;
    const double c2 = 3 * part.depth - 2 * a - b, c3 = a + b - 2 * part.depth;
    const double depth = u * (a + u * (c2 + u * c3));
    const double slope = (a + u * (2 * c2 + u * 3 * c3)) / part.length;
    return std::max(slope, 0.0) * std::exp(-(part.before + depth));
  }

 private:
  struct Part {
    double begin, length;
    double first, last;  ///< extinction [1/m]
    double depth, before;
  };

  std::vector<Part> parts_;
  double depth_ = 0;
};

/// Within 5e-3 of the angle of (x, y), -pi..pi: a hundredth of what lies between known ways.
double roughAngle(double x, double y) {
  const double across = std::abs(x), up = std::abs(y);
  const double most = std::max(across, up);
  if (!(most > 0))
    return 0;
  const double r = std::min(across, up) / most;
  double angle = r * (kPi / 4 + 0.273 * (1 - r));
  if (up > across)
    angle = kPi / 2 - angle;
  if (x < 0)
    angle = kPi - angle;
  return y < 0 ? -angle : angle;
}

/// Two lamps as one.
Lamp together(const Lamp& a, const Lamp& b) {
  const double share = b.intensity.sum() / (a.intensity.sum() + b.intensity.sum());
  Lamp one = a;
  one.position = (1 - share) * a.position + share * b.position;
  one.intensity = a.intensity + b.intensity;
  one.radius = std::max((a.position - one.position).norm() + a.radius,
                        (b.position - one.position).norm() + b.radius);
  return one;
}

/// The lamps that shine, the closest ones together until there are few.
std::vector<Lamp> fewLamps(std::span<const Lamp> lamps) {
  std::vector<Lamp> few;
  for (const Lamp& lamp : lamps) {
    if (lamp.kind != Lamp::Kind::kSun && lamp.intensity.maxCoeff() > 0)
      few.push_back(lamp);
  }
  while (few.size() > kMaxLamps) {
    std::size_t first = 0, second = 1;
    double closest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < few.size(); ++i) {
      for (std::size_t k = i + 1; k < few.size(); ++k) {
        const double far = (few[i].position - few[k].position).norm();
        if (far < closest)
          closest = far, first = i, second = k;
      }
    }
    few[first] = together(few[first], few[second]);
    few.erase(few.begin() + static_cast<std::ptrdiff_t>(second));
  }
  return few;
}

}  // namespace

LampLitMedium::LampLitMedium(AnyMedium medium, AnyMedium density, std::span<const Lamp> lamps,
                             const LampScattering& scattering)
    : medium_(std::move(medium)),
      density_(std::move(density)),
      albedo_(scattering.albedo),
      asymmetry_(scattering.asymmetry) {
  auto lights = std::make_shared<std::vector<Light>>();
  for (const Lamp& lamp : fewLamps(lamps)) {
    lights->push_back({lamp, {}});
    lights->back().spread(density_, scattering);
  }
  if (lights->size() > 1) {
    Lamp all = lights->front().lamp;
    for (std::size_t i = 1; i < lights->size(); ++i) all = together(all, (*lights)[i].lamp);
    spread_ = all.radius;
    auto one = std::make_shared<Light>(Light{all, {}});
    one->spread(density_, scattering);
    afar_ = std::move(one);
  }
  lights_ = std::move(lights);
}

Rgb LampLitMedium::source(const Vec3& point, const Vec3* direction) const {
  Rgb sum = Rgb::Zero();
  const auto add = [&](const Light& light) {
    double phase = 1 / (4 * kPi);
    const Vec3 away = point - light.lamp.position;
    if (direction && asymmetry_ != 0 && away.norm() > 0)
      phase = henyeyGreenstein(asymmetry_, -away.normalized().dot(*direction));
    sum += phase * light.shareAt(point) * light.lamp.irradiance(point);
  };
  if (afar_ && (point - afar_->lamp.position).norm() > kAfar * spread_) {
    add(*afar_);
  } else {
    for (const Light& light : *lights_) add(light);
  }
  return albedo_ * sum;
}

Rgb LampLitMedium::emission(const Vec3& point) const {
  return medium_.emission(point) + density_.extinction(point) * source(point, nullptr);
}

void LampLitMedium::cut(const Segment& segment, const Piece& piece, std::vector<Piece>& out) const {
  const auto cutOnce = [&](auto&& self, const Piece& part, int cuts) -> void {
    const double length = part.end - part.begin;
    const auto at = [&](double share) {
      return source(segment.at(part.begin + share * length), &segment.direction);
    };
    const Rgb first = at(0), middle = at(0.5), last = at(1);
    const bool room = part.extinction.terms() <= Polynomial::kTerms - 2;
    const Rgb a = room ? first : middle;
    const Rgb c = room ? Rgb(2 * (first + last - 2 * middle)) : Rgb::Zero();
    const Rgb b = room ? Rgb(last - first - c) : Rgb::Zero();
    double error = 0;
    for (double x : {0.25, 0.75}) {
      const Rgb there = at(x);
      error = std::max(
          error, (a + b * x + c * x * x - there).abs().maxCoeff() - kTolerance * there.maxCoeff());
    }
    if (error > 0 && cuts < kMaxCuts) {
      const double half = part.begin + 0.5 * length;
      self(self, clipped(part, part.begin, half), cuts + 1);
      self(self, clipped(part, half, part.end), cuts + 1);
      return;
    }
    Piece lit = part;
    for (Eigen::Index k = 0; k < 3; ++k) {
      const Polynomial& density = part.extinction;
      lit.emission[k] += density.timesLine(a[k], b[k] / length);
      lit.emission[k] += density.timesLine(0, 1).timesLine(0, c[k] / (length * length));
    }
    out.push_back(lit);
  };
  cutOnce(cutOnce, piece, 0);
}

void LampLitMedium::pieces(std::span<const Segment> segments,
                           std::span<std::vector<Piece>> pieces) const {
  std::vector<Piece> plain;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    pieces[i].clear();
    medium_.pieces(segments.subspan(i, 1), {&plain, 1});
    for (const Piece& piece : plain) {
      const bool endless = !std::isfinite(piece.end);
      if (piece.extinction.isZero() || lights_->empty() || (endless && !(piece.decay > 0))) {
        pieces[i].push_back(piece);
        continue;
      }
      const double last = endless ? piece.begin + kGone / piece.decay : piece.end;
      cut(segments[i], clipped(piece, piece.begin, last), pieces[i]);
      if (endless)
        pieces[i].push_back(clipped(piece, last, piece.end));
    }
  }
}

Rgb LampLitMedium::scattered(const Segment& segment, std::span<const Piece> density) const {
  Rgb sum = Rgb::Zero();
  const AlongRay ray(density);
  if (ray.empty())
    return sum;
  const double begin = ray.begin(), end = ray.end();
  const auto add = [&](const Light& light, int nodes) {
    const double nearest = (light.lamp.position - segment.origin).dot(segment.direction);
    const double far =
        std::max((segment.at(nearest) - light.lamp.position).norm(), 0.5 * light.lamp.radius);
    const double from = std::atan2(begin - nearest, far), to = std::atan2(end - nearest, far);
    const auto between = [&](double a, double b) {
      if (!(a < b))
        return;
      const GaussRule rule = gaussRule(nodes);
      for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
        const double tangent = std::tan(0.5 * (a + b + (b - a) * rule.nodes[i]));
        const double s = nearest + far * tangent;
        const double thick =
            0.5 * (b - a) * rule.weights[i] * ray.at(s) * far * (1 + tangent * tangent);
        if (thick < kNothing)
          continue;
        const Vec3 point = segment.at(s);
        const Vec3 away = point - light.lamp.position;
        const double phase =
            henyeyGreenstein(asymmetry_, -away.normalized().dot(segment.direction));
        sum += phase * thick * light.shareAt(point) * light.lamp.irradiance(point);
      }
    };
    // Light has an edge where it comes within the lamp's size.
    const double miss = (segment.at(nearest) - light.lamp.position).norm();
    const double inside =
        std::sqrt(std::max(0.0, light.lamp.radius * light.lamp.radius - miss * miss));
    const double rim = std::atan2(inside, far);
    const double cuts[] = {from, std::clamp(-rim, from, to), std::clamp(0.0, from, to),
                           std::clamp(rim, from, to), to};
    for (int i = 0; i < 4; ++i) between(cuts[i], cuts[i + 1]);
  };
  if (afar_) {
    const Vec3& middle = afar_->lamp.position;
    const double nearest = std::clamp((middle - segment.origin).dot(segment.direction), begin, end);
    if ((segment.at(nearest) - middle).norm() > kAfar * spread_) {
      add(*afar_, 5);
      return albedo_ * sum;
    }
  }
  for (const Light& light : *lights_) add(light, 8);
  return albedo_ * sum;
}

void LampLitMedium::radiance(std::span<const Segment> segments, std::span<Radiance> out) const {
  medium_.radiance(segments, out);
  forPieces(density_, segments, [&](std::size_t i, const std::vector<Piece>& density) {
    out[i].emitted += scattered(segments[i], density);
  });
}

}  // namespace volute
