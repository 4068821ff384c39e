// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/lighting/lit_medium.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>

#include "volute/math/phase_function.hpp"
#include "volute/medium/integrate.hpp"

namespace volute {
namespace {

constexpr double kEvenly = 1 / (4 * std::numbers::pi);
constexpr double kLightTolerance = 2e-4;
constexpr int kMaxCuts = 12;
constexpr double kCellShare = 0.5;  ///< of a field's cell: no cuts of less
constexpr int kLitTerms = 8;  ///< of a piece's light: more cost more than the cuts that they save
constexpr double kGoneEfolds = 30;  ///< e-folds after which nothing is left
constexpr int kMaxSteps = 4096;
constexpr int kMaxParts = 64;         ///< of a step
constexpr double kPartDepth = 0.125;  ///< optical depth of a part
constexpr double kPartReach = 0.125;  ///< of the distance from a lamp: a part's length
constexpr double kRimParts = 16;     ///< on which the soft edge of a cone grows from nothing to all
constexpr int kRimSteps = 4;         ///< in which the medium is even, on such an edge
constexpr double kStepReach = 0.25;  ///< of the distance from a lamp: the length of such a step
constexpr double kStepLost = 1e-4;   ///< of the light that all steps may scatter towards the eye

/// The mean of 1 / max(distance, radius)^2 from a lamp on a part of a ray.
double meanInverseSquare(const Lamp& lamp, const Segment& ray, double begin, double end) {
  const double nearest = (lamp.position - ray.origin).dot(ray.direction);
  const double miss = (ray.at(nearest) - lamp.position).norm();
  const double a = begin - nearest, b = end - nearest, middle = 0.5 * (a + b);
  const double inside = std::hypot(miss, a * b <= 0 ? 0.0 : std::min(std::abs(a), std::abs(b)));
  if (inside < lamp.radius) {
    const double reach = std::max(std::hypot(miss, middle), lamp.radius);
    return 1 / (reach * reach);
  }
  if (!(b - a > 1e-9 * (std::abs(middle) + miss))) {
    const double reach = std::max(std::hypot(miss, middle), lamp.radius);
    return 1 / (reach * reach);
  }
  if (miss < 1e-3 * std::abs(middle))
    return 1 / (a * b);
  return (std::atan(b / miss) - std::atan(a / miss)) / (miss * (b - a));
}

/// Where in a part, 0..1, the light that it sends comes from in the mean; light that is linear
/// there is exact.
/// @param left  exp(-depth)
/// @param growth  of the extinction in the part, in parts of its mean
double centroid(double depth, double left, double growth) {
  const double even = depth < 1e-2 ? 0.5 - depth / 12 : 1 / depth - left / (1 - left);
  return even + growth / 12 * left;
}

/// How the extinction grows over a step, in parts of its mean, by the steps before and behind: it
/// is linear there, and nowhere below 0 or beyond them.
double growthOf(std::span<const Segment> steps, std::span<const double> depths, std::size_t k) {
  if (k == 0 || k + 1 >= steps.size() || !(depths[k] > 0))
    return 0;
  const auto length = [&](std::size_t i) { return steps[i].end - steps[i].begin; };
  const auto slope = [&](std::size_t i) {  // from step i to the next
    const double apart = 0.5 * (length(i) + length(i + 1));
    return (depths[i + 1] / length(i + 1) - depths[i] / length(i)) / apart;
  };
  const double before = slope(k - 1), after = slope(k);
  if (!(before * after > 0))
    return 0;
  const double most = 2 * std::min(std::abs(before), std::abs(after));
  const double growth = std::clamp(0.5 * (before + after), -most, most) * length(k) * length(k);
  return std::clamp(growth / depths[k], -2.0, 2.0);
}

/// Whether what a step swallows lies so unevenly in it that its place shows: how much depths change
/// around it, times how deep it is there, of the light that passes what is before.
bool isUneven(std::span<const Segment> steps, std::span<const double> depths, std::size_t k,
              double passed) {
  constexpr double kShows = 1e-3;
  const double own = depths[k], length = steps[k].end - steps[k].begin;
  if (!(own * passed > kShows) || !std::isfinite(length))
    return false;
  const auto there = [&](std::size_t i) {
    return depths[i] / (steps[i].end - steps[i].begin) * length;
  };
  const double before = k > 0 ? there(k - 1) : 0, after = k + 1 < steps.size() ? there(k + 1) : 0;
  const double changes = std::abs(own - before) + std::abs(after - own);
  return changes * std::max({before, own, after}) * passed > kShows;
}

double depthOf(const Radiance& part) {
  return -std::log(std::max(part.transmittance, 1e-300));
}

/// The steps of several rays, and what a medium does in each.
struct Steps {
  std::vector<std::size_t> begins;  ///< of each ray's, and behind the last one's
  std::vector<Segment> steps;
  std::vector<Radiance> parts;
  std::vector<double> depths;

  void add(const Segment& step, const Radiance& part) {
    steps.push_back(step), parts.push_back(part);
    depths.push_back(depthOf(part));
  }

  template <class T>
  std::span<const T> of(const std::vector<T>& all, std::size_t ray) const {
    return std::span(all).subspan(begins[ray], begins[ray + 1] - begins[ray]);
  }
};

/// With uneven steps cut.
Steps withoutUneven(const AnyMedium& medium, Steps from) {
  constexpr int kCuts = 4;
  std::vector<Segment> cut;
  std::vector<bool> isCut(from.steps.size(), false);
  for (std::size_t ray = 0; ray + 1 < from.begins.size(); ++ray) {
    const auto steps = from.of(from.steps, ray);
    const auto depths = from.of(from.depths, ray);
    double passed = 1;
    for (std::size_t k = 0; k < steps.size() && passed > kStepLost; ++k) {
      if (isUneven(steps, depths, k, passed)) {
        isCut[from.begins[ray] + k] = true;
        const double length = (steps[k].end - steps[k].begin) / kCuts;
        for (int i = 0; i < kCuts; ++i) {
          Segment& part = cut.emplace_back(steps[k]);
          part.begin = steps[k].begin + i * length;
          part.end = i + 1 < kCuts ? part.begin + length : steps[k].end;
        }
      }
      passed *= from.parts[from.begins[ray] + k].transmittance;
    }
  }
  if (cut.empty())
    return from;
  std::vector<Radiance> parts(cut.size());
  medium.radiance(cut, parts);
  Steps out;
  std::size_t next = 0;
  for (std::size_t ray = 0; ray + 1 < from.begins.size(); ++ray) {
    out.begins.push_back(out.steps.size());
    for (std::size_t k = from.begins[ray]; k < from.begins[ray + 1]; ++k) {
      if (!isCut[k])
        out.add(from.steps[k], from.parts[k]);
      for (int i = 0; i < kCuts && isCut[k]; ++i, ++next) out.add(cut[next], parts[next]);
    }
  }
  out.begins.push_back(out.steps.size());
  return out;
}

/// curve * (a + b s + c s^2).
Polynomial timesParabola(const Polynomial& curve, double a, double b, double c) {
  Polynomial out = curve.timesLine(a, b);
  if (c != 0)
    out += curve.timesLine(0, 1).timesLine(0, c);
  return out;
}

bool isDark(std::span<const Interval> dark, double s) {
  const auto next = std::ranges::upper_bound(dark, s, {}, &Interval::begin);
  return next != dark.begin() && s < std::prev(next)->end;
}

}  // namespace

/// A segment, its part that is lit, and what surfaces leave of that to each lamp.
class LitMedium::Ray {
 public:
  Ray(const LitMedium& medium, const Segment& segment)
      : segment_(segment),
        // Steps begin where the medium does: it is even in each.
        lit_(medium.options_.lit.intersect(segment.origin, segment.direction)
                 .intersect(medium.bounds().intersect(segment.origin, segment.direction))
                 .intersect({segment.begin, segment.end})) {
    const std::span<const LightField> fields = medium.fields_;
    dark_.resize(fields.size());
    for (const LightField& field : fields) cones_.push_back(inCone(field.lamp()));
    if (medium.options_.shadows && !lit_.empty()) {
      for (std::size_t i = 0; i < fields.size(); ++i) {
        const Interval& cone = cones_[i];
        if (!cone.empty()) {
          medium.options_.shadows({segment.origin, segment.direction, cone.begin, cone.end},
                                  fields[i].lamp(), dark_[i]);
        }
      }
      // Where a ray ends on a surface is a float: nothing is between that and the shadow's end.
      const double rounding = 1e-6 * std::max(std::abs(lit_.end), lit_.length());
      for (std::vector<Interval>& dark : dark_) {
        if (!dark.empty() && lit_.end - dark.back().end < rounding)
          dark.back().end = std::max(dark.back().end, lit_.end);
      }
    }
    reached_.assign(fields.size(), 1);
    for (std::size_t i = 0; i < fields.size(); ++i) {
      const Lamp& lamp = fields[i].lamp();
      if (!cones_[i].empty()) {
        if (lamp.kind != Lamp::Kind::kSun)  // there the phase jumps
          turns_.push_back((lamp.position - segment.origin).dot(segment.direction));
        addRim(lamp);
      }
      cosines_.push_back(-lamp.direction.dot(segment.direction));
      phases_.push_back(henyeyGreenstein(medium.options_.scattering.asymmetry, cosines_.back()));
    }
  }

  const Segment& segment() const { return segment_; }

  const Interval& lit() const { return lit_; }

  /// The ends of the parts of (begin, end) on which it is dark or light for each lamp alike, and
  /// before or behind it.
  std::vector<double> edges(double begin, double end) const {
    std::vector<double> edges;
    for (const auto& dark : dark_) {
      auto part = std::ranges::upper_bound(dark, begin, {}, &Interval::end);
      for (; part != dark.end() && part->begin < end; ++part) {
        for (const double edge : {part->begin, part->end}) {
          if (edge > begin && edge < end)
            edges.push_back(edge);
        }
      }
    }
    std::ranges::copy_if(turns_, std::back_inserter(edges),
                         [&](double s) { return s > begin && s < end; });
    std::ranges::sort(edges);
    edges.push_back(end);
    return edges;
  }

  /// From now on lamps reach it as they reach this place.
  void stand(double s) {
    for (std::size_t i = 0; i < dark_.size(); ++i) {
      const Interval& cone = cones_[i];
      reached_[i] = s > cone.begin && s < cone.end && !isDark(dark_[i], s);
    }
  }

  bool reached(std::size_t lamp) const { return reached_[lamp] != 0; }

  /// Of a sun's light that is scattered along the ray, and its cosine.
  double phase(std::size_t lamp) const { return phases_[lamp]; }

  double cosine(std::size_t lamp) const { return cosines_[lamp]; }

 private:
  /// The part that is lit as far as it may be in a lamp's cone.
  Interval inCone(const Lamp& lamp) const {
    if (lit_.empty() || lamp.kind == Lamp::Kind::kSun || !(lamp.coneCosine > 0))
      return lit_;
    std::vector<double> ends{lit_.begin, lit_.end};
    addCone(lamp, lamp.coneCosine, ends);
    for (double& end : ends) end = std::clamp(end, lit_.begin, lit_.end);
    std::ranges::sort(ends);
    for (std::size_t i = 0; i + 1 < ends.size(); ++i) {  // a narrow cone is met once
      const Vec3 away = segment_.at(0.5 * (ends[i] + ends[i + 1])) - lamp.position;
      if (ends[i] < ends[i + 1] && away.dot(lamp.direction) > lamp.coneCosine * away.norm())
        return {ends[i], ends[i + 1]};
    }
    return {lit_.begin, lit_.begin};
  }

  /// Where it enters and leaves a spot's cone and the part of it on which all light is, and places
  /// between, as the light grows there.
  void addRim(const Lamp& lamp) {
    if (lamp.kind == Lamp::Kind::kSun || lamp.coneCosine <= -1)
      return;
    std::vector<double> rims;
    addCone(lamp, lamp.coneCosine, rims);
    if (lamp.edge > 0)
      addCone(lamp, std::cos((1 - lamp.edge) * std::acos(lamp.coneCosine)), rims);
    std::ranges::sort(rims);
    for (std::size_t i = 0; i + 1 < rims.size(); ++i) {
      const double length = rims[i + 1] - rims[i];
      const double share = lamp.coneShare(segment_.at(rims[i] + 0.5 * length));
      for (int k = 1; share > 0 && share < 1 && k < kRimSteps; ++k)
        turns_.push_back(rims[i] + length * k / kRimSteps);
    }
    turns_.insert(turns_.end(), rims.begin(), rims.end());
  }

  /// Where it crosses a cone around a spot's axis.
  void addCone(const Lamp& lamp, double cosine, std::vector<double>& rims) const {
    // (a + b s)^2 = cos^2 (from + s direction)^2, and the place behind the lamp that does so, too.
    const Vec3 from = segment_.origin - lamp.position;
    const double a = from.dot(lamp.direction), b = segment_.direction.dot(lamp.direction);
    const double square = cosine * cosine;
    const double p = b * b - square, q = a * b - square * from.dot(segment_.direction);
    const double root = q * q - p * (a * a - square * from.squaredNorm());
    if (!(root > 0) || p == 0)
      return;
    for (const double sign : {-1.0, 1.0}) rims.push_back((-q + sign * std::sqrt(root)) / p);
  }

  Segment segment_;
  Interval lit_;
  std::vector<Interval> cones_;  ///< of each lamp
  std::vector<std::vector<Interval>> dark_;
  std::vector<char> reached_;
  std::vector<double> phases_, cosines_;  ///< of suns
  std::vector<double> turns_;             ///< nearest to other lamps, and at the rims of cones
};

LitMedium::LitMedium(AnyMedium medium, std::vector<LightField> fields, Options options)
    : medium_(std::move(medium)), fields_(std::move(fields)), options_(std::move(options)) {}

LitMedium::Source LitMedium::source(const Ray& ray, const Vec3& point) const {
  Source sum;
  for (std::size_t i = 0; i < fields_.size(); ++i) {
    if (!ray.reached(i))
      continue;
    const Lamp& lamp = fields_[i].lamp();
    double phase = ray.phase(i), cosine = ray.cosine(i);
    if (lamp.kind != Lamp::Kind::kSun) {
      const Vec3 away = point - lamp.position;
      const double distance = away.norm();
      cosine = distance > 0 ? -away.dot(ray.segment().direction) / distance : 0;
      phase = distance > 0 ? henyeyGreenstein(options_.scattering.asymmetry, cosine) : kEvenly;
    }
    const Rgb arriving = lamp.irradiance(point);
    if (!(arriving > 0).any())
      continue;
    const LightField::Sample sample = fields_[i].at(point);
    sum.light += (sample.share * phase + goesOn(sample.share, cosine)) * arriving;
    if (sample.cell > 0)
      sum.cell = sum.cell > 0 ? std::min(sum.cell, sample.cell) : sample.cell;
  }
  if (options_.again)
    sum.light += options_.again->towards(point, -ray.segment().direction);
  sum.light *= options_.scattering.albedo;
  return sum;
}

/// Light of a share that was scattered forwards on its way, and is again by an angle.
double LitMedium::goesOn(double share, double cosine) const {
  const Scattering& scattering = options_.scattering;
  const double more = options_.again ? scattering.goesOn(share) : 0;
  return more > 0 ? more * henyeyGreenstein(scattering.forward(), cosine) : 0;
}

double LitMedium::evenFor(const Ray& ray, const Vec3& point) const {
  double even = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < fields_.size(); ++i) {
    if (!ray.reached(i))
      continue;
    const LightField& field = fields_[i];
    even = std::min(even, field.evenFor(point));
    const Lamp& lamp = field.lamp();
    if (lamp.kind != Lamp::Kind::kSun)
      even = std::min(even, kStepReach * std::max((point - lamp.position).norm(), lamp.radius));
  }
  return even;
}

Rgb LitMedium::emission(const Vec3& point) const {
  Rgb sum = Rgb::Zero();
  if (options_.lit.contains(point)) {
    for (const LightField& field : fields_)
      sum += field.at(point).share * kEvenly * field.lamp().irradiance(point);
    if (options_.again)
      sum += options_.again->at(point);
  }
  return medium_.emission(point) + medium_.extinction(point) * options_.scattering.albedo * sum;
}

void LitMedium::cut(const Ray& ray, const Piece& piece, int cuts, std::vector<Piece>& out) const {
  const double length = piece.end - piece.begin;
  const auto at = [&](double share) {
    return source(ray, ray.segment().at(piece.begin + share * length));
  };
  const int room = kLitTerms - piece.extinction.terms();  // degrees that may be added
  const Source centre = at(0.5);
  const Rgb first = at(0).light, middle = centre.light, last = at(1).light;
  // The light as a + b x + c x^2 with x from 0 to 1.
  const Rgb c = room >= 2 ? Rgb(2 * (first + last - 2 * middle)) : Rgb(Rgb::Zero());
  const Rgb a = room >= 1 ? first : middle;
  const Rgb b = room >= 1 ? Rgb(last - first - c) : Rgb(Rgb::Zero());
  double error = 0;
  for (const double x : {0.25, 0.75}) {
    const Rgb there = at(x).light;
    error = std::max(error, (a + b * x + c * x * x - there).abs().maxCoeff() -
                                kLightTolerance * there.maxCoeff());
  }
  // Between the nodes of a field the light has edges that it only has there.
  if (error > 0 && cuts < kMaxCuts && !(length < kCellShare * centre.cell)) {
    const double half = piece.begin + 0.5 * length;
    cut(ray, clipped(piece, piece.begin, half), cuts + 1, out);
    cut(ray, clipped(piece, half, piece.end), cuts + 1, out);
    return;
  }
  Piece lit = piece;
  for (int k = 0; k < 3; ++k) {
    lit.emission[k] +=
        timesParabola(piece.extinction, a[k], b[k] / length, c[k] / (length * length));
  }
  out.push_back(lit);
}

void LitMedium::pieces(std::span<const Segment> segments,
                       std::span<std::vector<Piece>> pieces) const {
  std::vector<std::vector<Piece>> plain(segments.size());
  medium_.pieces(segments, plain);
  for (std::size_t i = 0; i < segments.size(); ++i) {
    pieces[i].clear();
    Ray ray(*this, segments[i]);
    for (const Piece& piece : plain[i]) {
      const bool endless = !std::isfinite(piece.end);
      const double last =
          endless && piece.decay > 0 ? piece.begin + kGoneEfolds / piece.decay : piece.end;
      const double begin = std::clamp(ray.lit().begin, piece.begin, last);
      const double end = std::clamp(ray.lit().end, begin, last);
      if (piece.extinction.isZero() || !(begin < end)) {
        pieces[i].push_back(piece);
        continue;
      }
      if (begin > piece.begin)
        pieces[i].push_back(clipped(piece, piece.begin, begin));
      double from = begin;
      for (const double to : ray.edges(begin, end)) {
        ray.stand(0.5 * (from + to));
        cut(ray, clipped(piece, from, to), 0, pieces[i]);
        from = to;
      }
      if (end < piece.end)
        pieces[i].push_back(clipped(piece, end, piece.end));
    }
  }
}

void LitMedium::radiance(std::span<const Segment> segments, std::span<Radiance> out) const {
  if (dependsOnEnd())  // so it cannot be asked in steps
    return radianceByPieces(*this, segments, out);
  std::vector<Ray> rays;
  std::vector<SunPlaces> suns(fields_.size());
  for (std::size_t first = 0; first < segments.size(); first += kSegmentsAtOnce) {
    const std::size_t count = std::min(kSegmentsAtOnce, segments.size() - first);
    rays.clear();
    Steps all;
    for (const Segment& segment : segments.subspan(first, count)) {
      Ray& ray = rays.emplace_back(*this, segment);
      all.begins.push_back(all.steps.size());
      Segment step = segment;
      const auto until = [&](double s) {
        step.end = s;
        if (!step.empty())
          all.steps.push_back(step);
        step.begin = s;
      };
      if (!ray.lit().empty()) {
        until(ray.lit().begin);
        for (const double edge : ray.edges(ray.lit().begin, ray.lit().end)) {
          const double from = step.begin, length = edge - from;
          ray.stand(from + 0.5 * length);
          const int pieces =
              std::clamp(static_cast<int>(std::min(length / options_.step, 1e6)) + 1, 1, kMaxSteps);
          int left = kMaxSteps;
          for (int k = 1; k <= pieces; ++k) {
            const double to = k == pieces ? edge : from + length * k / pieces;
            for (; left > 0; --left) {  // finer in shadows of media
              const double even = evenFor(ray, segment.at(step.begin));
              if (step.begin + 1.5 * even >= to)
                break;
              until(step.begin + even);
            }
            until(to);
          }
        }
      }
      until(segment.end);
    }
    all.begins.push_back(all.steps.size());
    all.parts.resize(all.steps.size());
    medium_.radiance(all.steps, all.parts);
    for (const Radiance& part : all.parts) all.depths.push_back(depthOf(part));
    all = withoutUneven(medium_, std::move(all));
    for (std::size_t i = 0; i < count; ++i) {
      const auto itsSteps = all.of(all.steps, i);
      const auto itsDepths = all.of(all.depths, i);
      Radiance sum;
      for (std::size_t k = 0; k < itsSteps.size(); ++k)
        add(rays[i], itsSteps, all.parts[all.begins[i] + k], itsDepths, k, suns, sum);
      addSuns(rays[i], suns, sum);
      out[first + i] = sum;
    }
  }
}

/// The light of suns that are known, at all places of a ray.
void LitMedium::addSuns(const Ray& ray, std::span<SunPlaces> suns, Radiance& sum) const {
  for (std::size_t i = 0; i < suns.size(); ++i) {
    auto& [points, given, shares] = suns[i];
    if (points.empty())
      continue;
    shares.resize(points.size());
    fields_[i].known()->shares(points, shares);
    double light = 0;
    for (std::size_t k = 0; k < points.size(); ++k)
      light += given[k] * (ray.phase(i) * shares[k] + goesOn(shares[k], ray.cosine(i)));
    sum.emitted += light * options_.scattering.albedo * fields_[i].lamp().intensity;
    points.clear(), given.clear();
  }
}

/// Step k behind those of `sum`.
/// @param suns  one for each field: of those that are known, what is to be asked
void LitMedium::add(Ray& ray, std::span<const Segment> steps, const Radiance& own,
                    std::span<const double> depths, std::size_t k, std::span<SunPlaces> suns,
                    Radiance& sum) const {
  const Segment& step = steps[k];
  sum.emitted += sum.transmittance * own.emitted;
  const double before = sum.transmittance;
  sum.transmittance *= own.transmittance;
  const Interval& lit = ray.lit();
  const double middle = 0.5 * (step.begin + step.end);
  const double lost = kStepLost * (step.end - step.begin) / lit.length();
  if (!(before * (1 - own.transmittance) > lost) || !(middle > lit.begin && middle < lit.end))
    return;
  ray.stand(middle);
  const double depth = depths[k], growth = growthOf(steps, depths, k),
               length = step.end - step.begin;
  const int thick = static_cast<int>(std::min(depth / kPartDepth, 1e3)) + 1;
  const double middleOfLight = centroid(depth, own.transmittance, growth);
  // Begin, end and middle of the light of each of several parts, and how much of its light passes.
  const auto forParts = [&](int count, auto&& part) {
    double passed = 1;
    double each = count > 1 ? std::exp(-depth / count) : own.transmittance;
    double place = count > 1 ? centroid(depth / count, each, growth / count) : middleOfLight;
    for (int k = 0; k < count && passed > kStepLost; ++k) {
      const double begin = step.begin + length * k / count, end = begin + length / count;
      if (growth != 0 && count > 1) {
        const double dense = 1 + growth * ((k + 0.5) / count - 0.5);
        each = std::exp(-depth * dense / count);
        place = centroid(depth * dense / count, each, growth / (count * dense));
      }
      part(begin, end, begin + place * (end - begin), passed * (1 - each));
      passed *= each;
    }
  };
  Rgb light = Rgb::Zero();
  for (std::size_t i = 0; i < fields_.size(); ++i) {
    if (!ray.reached(i))
      continue;
    const LightField& field = fields_[i];
    const Lamp& lamp = field.lamp();
    const bool sun = lamp.kind == Lamp::Kind::kSun;
    if (sun && field.isKnown()) {
      forParts(std::min(thick, kMaxParts), [&](double, double, double place, double given) {
        suns[i].points.push_back(step.at(place));
        suns[i].given.push_back(before * given);
      });
      continue;
    }
    int count = thick;
    LightField::Sample seen =
        field.at(step.at(step.begin + length * (thick > 1 ? 0.5 : middleOfLight)));
    if (seen.cell > 0)
      count = std::max(count, static_cast<int>(std::min(length / seen.cell, 1e3)));
    if (!sun) {
      const double nearest =
          std::clamp((lamp.position - step.origin).dot(step.direction), step.begin, step.end);
      const double distance = (step.at(nearest) - lamp.position).norm();
      count = std::max(count, static_cast<int>(std::min(
                                  length / (kPartReach * std::max(distance, lamp.radius)), 1e3)) +
                                  1);
    }
    if (!sun && lamp.coneCosine > -1) {  // at a soft rim
      const auto [low, high] =
          std::minmax({lamp.coneShare(step.at(step.begin)), lamp.coneShare(step.at(middle)),
                       lamp.coneShare(step.at(step.end))});
      count = std::max(count, 1 + static_cast<int>(kRimParts * (high - low)));
    }
    double share = 0;
    forParts(std::min(count, kMaxParts), [&](double begin, double end, double place, double given) {
      const Vec3 point = step.at(place);
      double arriving = ray.phase(i), cosine = ray.cosine(i), falls = 1;
      if (!sun) {
        const Vec3 away = point - lamp.position;
        const double distance = away.norm();
        cosine = distance > 0 ? -away.dot(step.direction) / distance : 0;
        const double middle = (step.at(0.5 * (begin + end)) - lamp.position).norm();
        const double nearer = std::max(middle, lamp.radius) / std::max(distance, lamp.radius);
        falls = lamp.coneShare(point) * meanInverseSquare(lamp, step, begin, end) * nearer * nearer;
        arriving = henyeyGreenstein(options_.scattering.asymmetry, cosine) * falls;
      }
      if (count > 1)
        seen = arriving > 0 ? field.at(point) : LightField::Sample{};
      share += given * (arriving * seen.share + falls * goesOn(seen.share, cosine));
    });
    light += share * lamp.intensity;
  }
  if (options_.again) {
    const Vec3 point = step.at(step.begin + length * middleOfLight);
    light += (1 - own.transmittance) * options_.again->towards(point, -step.direction);
  }
  sum.emitted += before * options_.scattering.albedo * light;
}

}  // namespace volute
