// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/medium/conformance/segments.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>

#include "volute/medium/conformance/random.hpp"

namespace volute::conformance {
namespace {

constexpr double kUnbounded = std::numeric_limits<double>::infinity();
constexpr std::array kAxisNames{"x", "y", "z"};

/// The first, the last and one in the middle.
std::vector<double> some(const std::vector<double>& planes) {
  if (planes.size() <= 3)
    return planes;
  return {planes.front(), planes[planes.size() / 2], planes.back()};
}

class Generator {
 public:
  explicit Generator(const MediumUnderTest& tested)
      : traits_(tested.traits), diagonal_(traits_.region.size().norm()), random_(traits_.seed) {}

  std::vector<NamedSegment> all() {
    for (int i = 0; i < 6; ++i) anywhere();
    for (int axis = 0; axis < 3; ++axis) {
      parallelToAxis(axis);
      inAPlane(axis);
      for (double plane : some(traits_.planes[axis])) alongFace(axis, plane);
      alongEdges(axis);
    }
    diagonals();
    throughVertices();
    return std::move(out_);
  }

 private:
  Vec3 point() { return random_.pointIn(traits_.region); }

  void add(std::string what, const Vec3& origin, const Vec3& direction, double begin, double end,
           std::vector<Vec3> sides = {}) {
    out_.push_back({std::move(what), {origin, direction, begin, end}, std::move(sides)});
  }

  void anywhere() {
    const Vec3 p = point(), q = point(), d = random_.direction();
    const double far = 1.5 * diagonal_;
    add("through", p - far * d, d, 0, 2 * far);
    add("through, from behind its origin", p, d, -far, far);
    add("from inside", p, d, 0, far);
    add("to the inside", p - far * d, d, 0, far);
    add("inside", p, (q - p).normalized(), 0, (q - p).norm());
    add("to infinity", p - far * d, d, 0, kUnbounded);
    add("from inside to infinity", p, d, 0, kUnbounded);
    add("from minus infinity to infinity", p, d, -kUnbounded, kUnbounded);
    add("from minus infinity to the inside", p, d, -kUnbounded, 0);
    add("very short", p, d, 0, 1e-9 * diagonal_);
    add("from far away", p - 1000 * diagonal_ * d, d, 0, 2000 * diagonal_);
    add("anywhere", p + 2 * (q - p), random_.direction(), 0, far);
  }

  void parallelToAxis(int axis) {
    for (double sign : {-1.0, 1.0}) {
      const Vec3 d = sign * Vec3::Unit(axis);
      add(fmt::format("parallel to {}", kAxisNames[axis]), point(), d, -2 * diagonal_,
          2 * diagonal_);
      add(fmt::format("parallel to {}, infinite", kAxisNames[axis]), point(), d, -kUnbounded,
          kUnbounded);
    }
    Vec3 almost = Vec3::Constant(1e-13);
    almost[axis] = 1;
    add(fmt::format("almost parallel to {}", kAxisNames[axis]), point(), almost.normalized(),
        -2 * diagonal_, 2 * diagonal_);
  }

  /// One component of the direction is zero; the origin lies on no face.
  void inAPlane(int axis) {
    Vec3 d = random_.direction();
    d[axis] = 0;
    add(fmt::format("no {} in the direction", kAxisNames[axis]), point(), d.normalized(),
        -2 * diagonal_, 2 * diagonal_);
  }

  void alongFace(int axis, double plane) {
    Vec3 p = point();
    p[axis] = plane;
    Vec3 d = random_.direction();
    add(fmt::format("begins on the face {} = {}", kAxisNames[axis], plane), p, d, 0, 2 * diagonal_);
    add(fmt::format("ends on the face {} = {}", kAxisNames[axis], plane), p, d, -2 * diagonal_, 0);
    d[axis] = 0;
    const std::vector<Vec3> sides{Vec3::Unit(axis), -Vec3::Unit(axis)};
    const std::string what = fmt::format("along the face {} = {}", kAxisNames[axis], plane);
    add(what, p, d.normalized(), -2 * diagonal_, 2 * diagonal_, sides);
    add(what + ", parallel to an axis", p, Vec3::Unit((axis + 1) % 3), -2 * diagonal_,
        2 * diagonal_, sides);
  }

  /// Parallel to `axis`, on planes of both other axes.
  void alongEdges(int axis) {
    const int a = (axis + 1) % 3, b = (axis + 2) % 3;
    std::vector<Vec3> sides;
    for (double i : {-1, 1}) {
      for (double j : {-1, 1})
        sides.push_back((i * Vec3::Unit(a) + j * Vec3::Unit(b)).normalized());
    }
    for (double planeA : some(traits_.planes[a])) {
      for (double planeB : some(traits_.planes[b])) {
        Vec3 p = point();
        p[a] = planeA;
        p[b] = planeB;
        add(fmt::format("along the edge {} = {}, {} = {}", kAxisNames[a], planeA, kAxisNames[b],
                        planeB),
            p, Vec3::Unit(axis), -2 * diagonal_, 2 * diagonal_, sides);
      }
    }
  }

  /// Through corners of cells, in space and in a face.
  void diagonals() {
    const auto& planes = traits_.planes;
    if (planes[0].empty() || planes[1].empty() || planes[2].empty())
      return;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto pick = [&](int axis) { return planes[axis][i % planes[axis].size()]; };
      const Vec3 corner(pick(0), pick(1), pick(2));
      const double sign = i % 2 ? -1 : 1;
      add("diagonal through corners", corner, Vec3(1, sign, 1).normalized(), -2 * diagonal_,
          2 * diagonal_);
      add("diagonal in a face", corner, Vec3(1, sign, 0).normalized(), -2 * diagonal_,
          2 * diagonal_, {Vec3::UnitZ(), -Vec3::UnitZ()});
    }
  }

  void throughVertices() {
    const auto& vertices = traits_.vertices;
    for (std::size_t i = 0; i + 1 < vertices.size() && i < 12; ++i) {
      const Vec3 d = (vertices[i + 1] - vertices[i]).normalized();
      const Vec3 a = d.unitOrthogonal(), b = d.cross(a);
      std::vector<Vec3> sides;
      for (int k = 0; k < 8; ++k)
        sides.push_back(std::cos(k * M_PI / 4) * a + std::sin(k * M_PI / 4) * b);
      add(fmt::format("through vertices {} and {}", i, i + 1), vertices[i], d, -diagonal_,
          2 * diagonal_, sides);
    }
  }

  const Traits& traits_;
  double diagonal_;
  Random random_;
  std::vector<NamedSegment> out_;
};

}  // namespace

std::vector<NamedSegment> segmentsOf(const MediumUnderTest& tested) {
  return Generator(tested).all();
}

std::vector<NamedSegment> genericSegmentsOf(const MediumUnderTest& tested) {
  std::vector<NamedSegment> segments = segmentsOf(tested);
  std::erase_if(segments, [](const NamedSegment& named) { return !named.sides.empty(); });
  return segments;
}

std::vector<NamedSegment> emptySegmentsOf(const MediumUnderTest& tested) {
  Random random(tested.traits.seed + 1);
  const Vec3 p = random.pointIn(tested.traits.region);
  std::vector<NamedSegment> out;
  for (const Vec3& d : {random.direction(), Vec3(Vec3::UnitX()), Vec3(-Vec3::UnitZ())}) {
    const auto add = [&](double begin, double end) {
      out.push_back({"empty", {p, d, begin, end}});
    };
    add(0, 0);
    add(1, 1);
    add(0.1 * tested.traits.region.size().norm(), 0);
    add(kUnbounded, kUnbounded);
    add(-kUnbounded, -kUnbounded);
    add(kUnbounded, -kUnbounded);
    add(0, -kUnbounded);
  }
  return out;
}

std::vector<NamedSegment> missingSegmentsOf(const MediumUnderTest& tested) {
  Random random(tested.traits.seed + 2);
  const Box3 bounds = tested.medium.bounds();
  const double length = tested.traits.region.size().norm();
  std::vector<NamedSegment> out;
  for (int axis = 0; axis < 3; ++axis) {
    for (double face : {bounds.min[axis], bounds.max[axis]}) {
      if (std::isinf(face))
        continue;
      const double outwards = face == bounds.min[axis] ? -1 : 1;
      Vec3 p = random.pointIn(tested.traits.region);
      p[axis] = face + outwards * 0.01 * length;
      Vec3 d = random.direction();
      d[axis] = 0;
      out.push_back({"passes by", {p, d.normalized(), -kUnbounded, kUnbounded}});
      out.push_back(
          {"passes by, parallel to an axis", {p, Vec3::Unit((axis + 1) % 3), -length, length}});
      d[axis] = outwards;
      out.push_back({"leads away", {p, d.normalized(), 0, kUnbounded}});
      out.push_back({"ends before", {p, -d.normalized(), -length, 0.005 * length}});
    }
  }
  return out;
}

std::vector<Segment> batchOf(std::span<const NamedSegment> segments) {
  std::vector<Segment> batch;
  for (const NamedSegment& named : segments) batch.push_back(named.segment);
  return batch;
}

}  // namespace volute::conformance
