// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/lighting/vertex_light.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "volute/base/assert.hpp"
#include "volute/base/parallel.hpp"
#include "volute/lighting/inner_points.hpp"
#include "volute/lighting/lamp_runs.hpp"
#include "volute/lighting/share_fit.hpp"

namespace volute {
namespace {

constexpr std::size_t kGrain = 256;

/// Two ways out of a tet as near as this, of the mesh's size, are one edge.
constexpr double kNear = 1e-9;

double sizeOf(const TetMesh& mesh) {
  return mesh.bounds().size().maxCoeff();
}

/// Up to where a way runs, cut where it has left the bounds: towards the sun it is endless.
double endOf(const Segment& way, const TetMesh& mesh) {
  return std::min(way.end, 4 * sizeOf(mesh) + (way.origin - mesh.bounds().centre()).norm());
}

bool meshBetween(const TetLocator& locator, const Segment& way, double begin) {
  std::vector<TetCrossing> crossings;
  locator.crossings({way.origin, way.direction, begin, endOf(way, locator.mesh())}, crossings);
  double length = 0;
  for (const TetCrossing& crossing : crossings) length += crossing.end - crossing.begin;
  return length > 1e-6 * sizeOf(locator.mesh());
}

}  // namespace

LampPaths::LampPaths(std::shared_ptr<const TetLocator> locator) : locator_(std::move(locator)) {
  const TetMesh& mesh = locator_->mesh();
  begin_.assign(mesh.vertices().size() + 1, 0);
  for (const Tet& tet : mesh.tets()) {
    for (const std::int32_t v : tet) ++begin_[static_cast<std::size_t>(v) + 1];
  }
  for (std::size_t i = 0; i + 1 < begin_.size(); ++i) begin_[i + 1] += begin_[i];
  around_.resize(static_cast<std::size_t>(begin_.back()));
  std::vector<std::int32_t> next(begin_.begin(), begin_.end() - 1);
  for (std::size_t t = 0; t < mesh.tets().size(); ++t) {
    for (const std::int32_t v : mesh.tets()[t]) around_[next[v]++] = static_cast<std::int32_t>(t);
  }
}

/// The tet around a vertex into which a direction points; -1: none.
std::int32_t LampPaths::firstTet(std::int32_t vertex, const Vec3& direction, bool& doubtful) const {
  const TetMesh& mesh = locator_->mesh();
  constexpr double kFlat = 1e-7;  // of the cosine: along a face
  for (std::int32_t i = begin_[vertex]; i < begin_[vertex + 1]; ++i) {
    const std::int32_t tet = around_[i];
    const auto slopes = mesh.slopes(tet);
    double least = 1;
    for (int k = 0; k < 4; ++k) {
      if (mesh.tets()[tet][k] != vertex)
        least = std::min(least, slopes[k].dot(direction) / slopes[k].norm());
    }
    if (least > kFlat) {
      doubtful = false;
      return tet;
    }
    doubtful |= least > -kFlat;
  }
  return -1;
}

namespace {

/// Smoke of one mesh at N times: one extinction for each vertex.
template <std::size_t N>
using Smokes = std::array<std::span<const float>, N>;

/// What a walk found out about each of N smokes.
template <std::size_t N>
struct Walk {
  std::array<double, N> depths{};
  bool dark = false;
  bool doubtful = false;  ///< the way meets an edge or a vertex
};

/// Axes across a way, and along it: what a walk looks along.
class AlongWay {
 public:
  explicit AlongWay(const Segment& way)
      : origin_(way.origin), along_(way.direction), right_(way.direction.unitOrthogonal()) {
    up_ = along_.cross(right_);
  }

  Vec3 operator()(const Vec3& point) const {
    const Vec3 from = point - origin_;
    return {from.dot(right_), from.dot(up_), from.dot(along_)};
  }

 private:
  Vec3 origin_, along_, right_, up_;
};

/// A vertex as a way sees it.
template <std::size_t N>
struct WalkCorner {
  Vec3 at;
  std::array<double, N> values{};
  std::int32_t vertex = -1;
};

/// Exchanging the ends changes the sign and nothing else.
template <std::size_t N>
double edgeBetween(const WalkCorner<N>& a, const WalkCorner<N>& b) {
  return a.at.x() * b.at.y() - a.at.y() * b.at.x();
}

/// The triangle through which a way passes, its corners anticlockwise; each weight is the edge
/// across from its corner.
template <std::size_t N>
struct WalkFace {
  WalkCorner<N> corners[3];
  double weights[3] = {};

  /// False where the way meets an edge.
  bool make() {
    for (int i = 0; i < 3; ++i)
      weights[i] = edgeBetween(corners[(i + 1) % 3], corners[(i + 2) % 3]);
    if (weights[0] < 0 && weights[1] < 0 && weights[2] < 0) {
      std::swap(corners[1], corners[2]);
      weights[0] = -weights[0];
      std::swap(weights[1], weights[2]);
      weights[1] = -weights[1], weights[2] = -weights[2];
    }
    return passed();
  }

  bool passed() const { return weights[0] > 0 && weights[1] > 0 && weights[2] > 0; }

  double distance() const {
    const Vec3 &a = corners[0].at, &b = corners[1].at, &c = corners[2].at;
    const double sum = weights[0] + weights[1] + weights[2];
    return a.z() + (weights[1] * (b.z() - a.z()) + weights[2] * (c.z() - a.z())) / sum;
  }

  std::array<double, N> values() const {
    const double sum = weights[0] + weights[1] + weights[2];
    std::array<double, N> out;
    for (std::size_t n = 0; n < N; ++n) {
      out[n] = (weights[0] * corners[0].values[n] + weights[1] * corners[1].values[n] +
                weights[2] * corners[2].values[n]) /
               sum;
    }
    return out;
  }

  /// On to the face by which the way leaves the tet that `ahead` completes. The vertex that is left
  /// behind, or -1 where the way meets an edge.
  std::int32_t advance(const WalkCorner<N>& ahead) {
    double to[3];
    for (int i = 0; i < 3; ++i) to[i] = edgeBetween(ahead, corners[i]);
    for (int i = 0; i < 3; ++i) {  // corner i is left behind: the way passes between the others
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      if (!(to[j] > 0 && to[k] < 0))
        continue;
      const std::int32_t left = corners[i].vertex;
      // What lies across from i, the edge j k, stays.
      weights[j] = -to[k], weights[k] = to[j];
      corners[i] = ahead;
      return passed() ? left : -1;
    }
    return -1;
  }
};

/// Along a way from a point of `tet`.
template <std::size_t N>
Walk<N> walkFrom(const TetLocator& locator, std::int32_t tet, const Segment& way,
                 const Smokes<N>& smokes, bool lampInside) {
  const TetMesh& mesh = locator.mesh();
  const double near = kNear * sizeOf(mesh);
  Walk<N> out;
  if (tet < 0) {
    if (way.end > near)
      out.dark = lampInside || meshBetween(locator, way, near);
    return out;
  }
  const auto points = mesh.vertices();
  // The first tet, in which the way begins, by its shares.
  const auto slopes = mesh.slopes(tet);
  const Tet& start = mesh.tets()[tet];
  const Vec3 from = way.origin - points[start[0]];
  double first = std::numeric_limits<double>::infinity(), second = first;
  std::array<double, N> before{}, rise{};
  int exit = -1;
  for (int k = 0; k < 4; ++k) {
    const double down = slopes[k].dot(way.direction);
    const double share = slopes[k].dot(from) + (k == 0 ? 1 : 0);
    for (std::size_t n = 0; n < N; ++n) {
      const double value = smokes[n][static_cast<std::size_t>(start[k])];
      before[n] += share * value;
      rise[n] += down * value;
    }
    if (!(down < 0))
      continue;
    const double leave = -share / down;
    if (leave < first) {
      second = first;
      first = leave;
      exit = k;
    } else {
      second = std::min(second, leave);
    }
  }
  double s = std::max(0.0, std::min(first, way.end));
  for (std::size_t n = 0; n < N; ++n) {
    out.depths[n] = (before[n] + 0.5 * rise[n] * s) * s;
    before[n] += rise[n] * s;
  }
  out.doubtful = exit < 0 || (first < way.end && second - first < near) || first < -near;
  if (out.doubtful || first >= way.end)
    return out;
  // The others from face to face, by the side of each edge that the way passes.
  const AlongWay seen(way);
  const auto corner = [&](std::int32_t vertex) {
    WalkCorner<N> made{seen(points[vertex]), {}, vertex};
    for (std::size_t n = 0; n < N; ++n)
      made.values[n] = smokes[n][static_cast<std::size_t>(vertex)];
    return made;
  };
  WalkFace<N> face{{corner(start[(exit + 1) & 3]), corner(start[(exit + 2) & 3]),
                    corner(start[(exit + 3) & 3])}};
  out.doubtful = !face.make();
  for (std::int32_t half = mesh.opposite(4 * tet + exit);
       half != TetMesh::kBoundary && !out.doubtful;) {
    const Tet& next = mesh.tets()[half / 4];
    const std::int32_t left = face.advance(corner(next[half & 3]));
    if (left < 0) {
      out.doubtful = true;
      break;
    }
    const double end = std::max(face.distance(), s);
    std::array<double, N> after = face.values();
    const bool arrives = end >= way.end;
    const double length = (arrives ? way.end : end) - s;
    for (std::size_t n = 0; n < N; ++n) {
      if (arrives)
        after[n] = before[n] + (end > s ? length / (end - s) : 0.0) * (after[n] - before[n]);
      out.depths[n] += 0.5 * (before[n] + after[n]) * length;
    }
    if (arrives)
      return out;
    s = end, before = after;
    const auto across = std::ranges::find(next, left) - next.begin();
    half = mesh.opposite(static_cast<std::int32_t>(half / 4 * 4 + across));
  }
  if (!out.doubtful && way.end - s > near)
    out.dark = lampInside || meshBetween(locator, way, s + near);
  return out;
}

double shareOf(const TetLocator& locator, std::span<const float> extinction, const Segment& way,
               const Walk<1>& walk) {
  if (locator.wallOn(way))
    return 0;
  if (walk.doubtful)
    return lampShareReference(locator, extinction, way);
  return walk.dark ? 0 : std::exp(-walk.depths[0]);
}

}  // namespace

std::vector<float> LampPaths::shares(std::span<const float> extinction, const Lamp& lamp) const {
  const TetMesh& mesh = locator_->mesh();
  VOLUTE_ASSERT(extinction.size() == mesh.vertices().size());
  const bool inside = lamp.kind == Lamp::Kind::kSpot && locator_->find(lamp.position) >= 0;
  std::vector<float> shares(extinction.size(), 0);
  parallelRanges(shares.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Segment way = lamp.towards(mesh.vertices()[i]);
      Walk<1> walk;
      const std::int32_t tet = firstTet(static_cast<std::int32_t>(i), way.direction, walk.doubtful);
      if (!walk.doubtful)
        walk = walkFrom<1>(*locator_, tet, way, {extinction}, inside);
      shares[i] = static_cast<float>(shareOf(*locator_, extinction, way, walk));
    }
  });
  return shares;
}

std::vector<float> LampPaths::means(
    std::span<const float> extinction, const Lamp& lamp, std::span<const float> shares,
    const std::function<void(std::span<const Vec3>, std::span<float>)>& others,
    double inside) const {
  const ShareFit fit(locator_->mesh(), extinction, shares);
  const auto places = fit.places();
  const bool lampInside = lamp.kind == Lamp::Kind::kSpot && locator_->find(lamp.position) >= 0;
  std::vector<float> there(places.size());
  parallelRanges(there.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      there[i] = static_cast<float>(
          lampShareAt(*locator_, extinction, lamp.towards(places[i]), fit.tets()[i], lampInside));
    }
  });
  if (others && inside > 0) {
    std::vector<Vec3> inner(places.begin(), places.end());
    for (std::size_t i = 0; i < inner.size(); ++i)
      inner[i] = innerPoint(locator_->mesh(), fit.tets()[i], places[i], inside);
    others(inner, there);
  } else if (others) {
    others(places, there);
  }
  return *fit.fitted(there);
}

double lampShareAt(const TetLocator& locator, std::span<const float> extinction, const Segment& way,
                   std::int32_t tet, bool lampInside) {
  return shareOf(locator, extinction, way,
                 walkFrom<1>(locator, tet, way, {extinction}, lampInside));
}

std::array<double, 2> lampDepthsAt(const TetLocator& locator,
                                   const std::array<std::span<const float>, 2>& extinctions,
                                   const Segment& way, std::int32_t tet, bool lampInside) {
  const auto walk = walkFrom<2>(locator, tet, way, extinctions, lampInside);
  if ((walk.dark && !walk.doubtful) || locator.wallOn(way))
    return {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  if (!walk.doubtful)
    return walk.depths;
  return {-std::log(lampShareReference(locator, extinctions[0], way)),
          -std::log(lampShareReference(locator, extinctions[1], way))};
}

double lampShareReference(const TetLocator& locator, std::span<const float> extinction,
                          const Segment& way) {
  if (locator.wallOn(way))
    return 0;
  const double near = 1e-6 * sizeOf(locator.mesh());
  const bool inside = std::isfinite(way.end) && locator.find(way.at(way.end)) >= 0;
  std::vector<LampRun> runs;
  appendLampRuns(locator, extinction, way, near, runs);
  return lampShareOf(runs, inside ? way.end : std::numeric_limits<double>::infinity(), near);
}

std::vector<float> scatteredLight(std::span<const Vec3> points, std::span<const Lamp> lamps,
                                  std::span<const std::vector<float>> shares, const Rgb& albedo,
                                  const Rgb& ambient, const DiffuseLight* again) {
  std::vector<float> light(3 * points.size());
  parallelRanges(points.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Rgb arriving = Rgb::Zero();
      for (std::size_t l = 0; l < lamps.size(); ++l)
        arriving += shares[l][i] * lamps[l].irradiance(points[i]);
      Rgb source = arriving / (4 * std::numbers::pi) + ambient;
      if (again)
        source += again->at(points[i]);
      source *= albedo;
      for (int c = 0; c < 3; ++c) light[3 * i + c] = static_cast<float>(source[c]);
    }
  });
  return light;
}

}  // namespace volute
