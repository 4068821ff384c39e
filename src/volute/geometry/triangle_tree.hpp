// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
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

  /// Calls `visit` for each triangle of the leaves whose boxes `mayMeet` wants.
  void select(const std::function<bool(const Box3&)>& mayMeet,
              const std::function<void(const Triangle&)>& visit) const;

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
};

}  // namespace volute
