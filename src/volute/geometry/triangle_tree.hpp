// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <span>
#include <vector>

#include "volute/geometry/triangle_scene.hpp"

namespace volute {

/// A tree of boxes over triangles, halved at the median: short, in double, and what the faster ways
/// are tested against.
class TriangleTree {
 public:
  /// The triangles must outlive it.
  explicit TriangleTree(std::span<const Triangle> triangles);

  Hit nearest(const Segment& segment) const;
  bool occluded(const Segment& segment) const;

  /// Calls `visit` for each triangle of the leaves all of whose boxes `mayMeet` wants.
  template <class MayMeet, class Visit>
  void select(MayMeet&& mayMeet, Visit&& visit) const;

  const Box3& bounds() const { return bounds_; }

 private:
  struct Node {
    Box3 box;
    std::uint32_t start = 0;  ///< of a leaf's triangles in order_, or the second child's number
    std::uint16_t count = 0;  ///< of a leaf's triangles; 0 has children, the first one follows it
    std::uint16_t axis = 0;   ///< the children lie one after the other along it
  };

  void build(std::uint32_t begin, std::uint32_t end);
  /// The part of the segment that is worth a look.
  Interval inside(const Segment& segment) const;

  std::span<const Triangle> triangles_;
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
  Box3 bounds_;  ///< of the triangles themselves

  static constexpr int kDeepest = 64;  ///< halving 2^31 triangles ends far earlier
};

template <class MayMeet, class Visit>
void TriangleTree::select(MayMeet&& mayMeet, Visit&& visit) const {
  std::array<std::uint32_t, kDeepest> stack;
  int depth = 0;
  if (!nodes_.empty())
    stack[depth++] = 0;
  while (depth > 0) {
    const std::uint32_t number = stack[--depth];
    const Node& node = nodes_[number];
    if (!mayMeet(node.box))
      continue;
    if (node.count == 0) {
      stack[depth++] = node.start;
      stack[depth++] = number + 1;
      continue;
    }
    for (std::uint32_t i = node.start; i < node.start + node.count; ++i)
      visit(triangles_[order_[i]]);
  }
}

}  // namespace volute
