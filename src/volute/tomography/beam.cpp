// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/beam.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace volute {
namespace {

// Rounding in the kernels' floats must not carry a ray beyond the last node.
constexpr double kMaxSpread = kBeamNodes - 2 - 1e-3;

// Nodes on the whole way that a ray may go down, as rounding has it for those along a plane.
constexpr double kLevel = 1e-7;

/// A ray in nodes of the lattice, along the three axes of its beam: two in the plane, and the one
/// along which it advances.
struct NodeRay {
  Vec3 origin, direction;  ///< origin + s direction, s in metres

  double at(int axis, double s) const { return origin[axis] + s * direction[axis]; }
};

/// The beam's axes in the lattice, and the size of the lattice along them.
struct BeamAxes {
  std::array<int, 3> axis{};
  std::array<int, 3> nodes{};
  std::array<bool, 3> down{};  ///< those that are descended
};

BeamAxes axesOf(const Support& support, const Vec3& direction) {
  BeamAxes axes;
  const Vec3 steps = direction.cwiseQuotient(support.cells().cell);
  int along = 0;
  steps.cwiseAbs().maxCoeff(&along);
  axes.axis = {along == 0 ? 1 : 0, along == 2 ? 1 : 2, along};
  for (int a = 0; a < 3; ++a) {
    axes.nodes[a] = support.boxSize()[axes.axis[a]] + 2;
    axes.down[a] = steps[axes.axis[a]] < 0;
  }
  return axes;
}

NodeRay nodeRay(const Support& support, const BeamAxes& axes, const Segment& segment) {
  const CellGrid& cells = support.cells();
  NodeRay ray;
  for (int a = 0; a < 3; ++a) {
    const int axis = axes.axis[a];
    const double first = cells.plane(axis, support.range().begin[axis]);
    ray.origin[a] = (segment.origin[axis] - first) / cells.cell[axis];
    ray.direction[a] = segment.direction[axis] / cells.cell[axis];
    if (axes.down[a]) {
      ray.origin[a] = axes.nodes[a] - 1 - ray.origin[a];
      ray.direction[a] = -ray.direction[a];
    }
  }
  return ray;
}

}  // namespace

bool makeBeam(const Support& support, std::span<const Segment> segments,
              std::span<const TouchedPart> touched, Beam& beam, std::span<BeamRay> rays) {
  if (segments.size() != kBeamRays)
    return false;
  Vec3 direction = Vec3::Zero();
  for (const Segment& segment : segments) direction += segment.direction;
  const BeamAxes axes = axesOf(support, direction);
  std::array<NodeRay, kBeamRays> ray;
  double low = axes.nodes[2], high = 0;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    ray[i] = nodeRay(support, axes, segments[i]);
    const Vec3& step = ray[i].direction;
    // No ray may advance faster in the plane than across it.
    if (!(step[2] > 0 && step[2] >= step[0] && step[2] >= step[1]))
      return false;
    if (touched[i].empty())
      continue;
    low = std::min(low, ray[i].at(2, touched[i].part.begin));
    high = std::max(high, ray[i].at(2, touched[i].part.end));
  }
  const int first = std::clamp(static_cast<int>(std::floor(low)), 0, axes.nodes[2] - 2);
  const int last = std::clamp(static_cast<int>(std::ceil(high)), first + 1, axes.nodes[2] - 1);
  beam.slabs = last - first;
  beam.turned = axes.axis[2] == 0 ? 1 : 0;
  const auto stride = beam.turned != 0 ? support.turnedStride() : support.stride();
  beam.node = support.nodeOf(support.range().begin);
  for (int a = 0; a < 3; ++a) {
    const std::int32_t along = stride[axes.axis[a]];
    beam.stride[a] = axes.down[a] ? -along : along;
    if (axes.down[a])
      beam.node += (axes.nodes[a] - 1) * along;
  }
  beam.node += first * beam.stride[2];
  for (int a = 0; a < 2; ++a) {
    std::array<double, kBeamRays> place{};
    double least = axes.nodes[a], spread[2]{}, steepest = 0;
    for (std::size_t i = 0; i < segments.size(); ++i) {
      const NodeRay& r = ray[i];
      const double s = (first - r.origin[2]) / r.direction[2], perSlab = 1 / r.direction[2];
      if (s < segments[i].begin || s + beam.slabs * perSlab > segments[i].end)
        return false;
      place[i] = r.at(a, s);
      const double slope = r.direction[a] * perSlab, end = place[i] + beam.slabs * slope;
      // All rays must ascend. One node beside the lattice is still one of the zeros around it, the
      // next may be any.
      if (end < place[i] - kLevel || place[i] < -1 || end > axes.nodes[a])
        return false;
      rays[i].slope[a] = static_cast<float>(std::max(slope, 0.0));
      rays[i].length = static_cast<float>(perSlab);
      least = std::min(least, place[i]);
      steepest = std::max(steepest, slope);
      for (std::size_t j = 0; j < i; ++j) {
        const double apart = place[i] - place[j];
        const double turn = slope - ray[j].direction[a] / ray[j].direction[2];
        spread[0] = std::max(spread[0], std::abs(apart));
        spread[1] = std::max(spread[1], std::abs(apart + beam.slabs * turn));
      }
    }
    if (std::max(spread[0], spread[1]) + steepest > kMaxSpread)
      return false;
    const int anchor = static_cast<int>(std::floor(least));
    beam.node += anchor * beam.stride[a];
    for (std::size_t i = 0; i < segments.size(); ++i)
      rays[i].place[a] = static_cast<float>(place[i] - anchor);
  }
  return true;
}

}  // namespace volute
