// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/geometry/triangle_tree.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "volute/geometry/triangle_hit.hpp"

namespace volute {
namespace {

constexpr std::uint32_t kLeaf = 4;

Box3 boxOf(const Triangle& triangle) {
  Box3 box;
  for (const Vec3& corner : triangle.corners) box.extend(corner);
  return box;
}

/// A box a little larger than the rounding of what is computed with it.
Box3 padded(Box3 box) {
  const double reach = std::max(box.min.cwiseAbs().maxCoeff(), box.max.cwiseAbs().maxCoeff());
  const Vec3 margin = Vec3::Constant(1e-12 * reach + 1e-300);
  box.min -= margin;
  box.max += margin;
  return box;
}

/// Whether a line may meet boxes; a NaN (a line along a face) counts as inside.
struct BoxTest {
  Vec3 origin, inverse;

  bool meets(const Box3& box, const Interval& part) const {
    double enter = part.begin, exit = part.end;
    for (int axis = 0; axis < 3; ++axis) {
      const bool up = inverse[axis] >= 0;
      const double in = ((up ? box.min : box.max)[axis] - origin[axis]) * inverse[axis];
      const double out = ((up ? box.max : box.min)[axis] - origin[axis]) * inverse[axis];
      enter = in > enter ? in : enter;
      exit = out < exit ? out : exit;
    }
    const double rounding = 1e-15 * (std::abs(part.begin) + std::abs(part.end));
    return enter <= exit + rounding;
  }
};

}  // namespace

TriangleTree::TriangleTree(std::span<const Triangle> triangles)
    : triangles_(triangles), order_(triangles.size()) {
  std::iota(order_.begin(), order_.end(), 0u);
  for (const Triangle& triangle : triangles) {
    for (const Vec3& corner : triangle.corners) bounds_.extend(corner);
  }
  if (!triangles.empty())
    build(0, static_cast<std::uint32_t>(triangles.size()));
}

void TriangleTree::build(std::uint32_t begin, std::uint32_t end) {
  Box3 box, centres;
  for (std::uint32_t i = begin; i < end; ++i) {
    const Box3 one = boxOf(triangles_[order_[i]]);
    box.extend(one);
    centres.extend(one.centre());
  }
  const std::size_t self = nodes_.size();
  nodes_.push_back({.box = padded(box)});
  if (end - begin <= kLeaf) {
    nodes_[self].start = begin;
    nodes_[self].count = static_cast<std::uint16_t>(end - begin);
    return;
  }
  int axis = 0;
  centres.size().maxCoeff(&axis);
  const std::uint32_t middle = begin + (end - begin) / 2;
  std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                   [&](std::uint32_t a, std::uint32_t b) {
                     return boxOf(triangles_[a]).centre()[axis] <
                            boxOf(triangles_[b]).centre()[axis];
                   });
  nodes_[self].axis = static_cast<std::uint16_t>(axis);
  build(begin, middle);
  nodes_[self].start = static_cast<std::uint32_t>(nodes_.size());
  build(middle, end);
}

Interval TriangleTree::inside(const Segment& segment) const {
  if (nodes_.empty())
    return {};
  return nodes_[0]
      .box.intersect(segment.origin, segment.direction)
      .intersect({segment.begin, segment.end});
}

Hit TriangleTree::nearest(const Segment& segment) const {
  Hit hit;
  Interval part = inside(segment);
  if (part.empty())
    return hit;
  Segment rest = segment;
  SegmentTest test(rest);
  const BoxTest boxes{segment.origin, segment.direction.cwiseInverse()};
  std::array<std::uint32_t, kDeepest> stack;
  int depth = 0;
  stack[depth++] = 0;
  while (depth > 0) {
    const std::uint32_t number = stack[--depth];
    const Node& node = nodes_[number];
    if (!boxes.meets(node.box, part))
      continue;
    if (node.count == 0) {
      const bool forward = segment.direction[node.axis] >= 0;
      stack[depth++] = forward ? node.start : number + 1;
      stack[depth++] = forward ? number + 1 : node.start;
      continue;
    }
    for (std::uint32_t i = node.start; i < node.start + node.count; ++i) {
      if (const auto distance = test.meets(triangles_[order_[i]])) {
        hit = {*distance, order_[i]};
        rest.end = part.end = *distance;
        test = SegmentTest(rest);
      }
    }
  }
  return hit;
}

bool TriangleTree::occluded(const Segment& segment) const {
  const Interval part = inside(segment);
  if (part.empty())
    return false;
  const SegmentTest test(segment);
  const BoxTest boxes{segment.origin, segment.direction.cwiseInverse()};
  std::array<std::uint32_t, kDeepest> stack;
  int depth = 0;
  stack[depth++] = 0;
  while (depth > 0) {
    const std::uint32_t number = stack[--depth];
    const Node& node = nodes_[number];
    if (!boxes.meets(node.box, part))
      continue;
    if (node.count == 0) {
      stack[depth++] = node.start;
      stack[depth++] = number + 1;
      continue;
    }
    for (std::uint32_t i = node.start; i < node.start + node.count; ++i) {
      if (test.meets(triangles_[order_[i]]))
        return true;
    }
  }
  return false;
}

}  // namespace volute
