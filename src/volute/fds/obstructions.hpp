// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "volute/fds/smv_index.hpp"
#include "volute/medium/medium.hpp"

namespace volute {

/// An obstruction that is there at some time; thin ones have equal ends on one axis.
struct FdsBox {
  Box3 bounds;
  std::array<FdsColour, 6> colours{};  ///< of the faces -x +x -y +y -z +z
  bool drawn = true;
};

/// A face to draw, counter-clockwise seen from outside.
struct FdsQuad {
  std::array<Vec3, 4> corners;
  FdsColour colour{};  ///< sRGB and opacity
  bool cut = false;    ///< is where a building was cut open, not its own face
};

/// In metres.
Box3 boxOf(const FdsMesh& mesh, const FdsNodeBox& nodes);

/// Of a place in SmvIndex::surfaces; FDS's usual one where there is none.
FdsColour surfaceColour(const SmvIndex& index, int surface);

/// The obstructions at one time, and what they hide. Cheap to copy.
class FdsObstructions {
 public:
  /// Those of `index` at a time [s]. An obstruction that an event takes away at t is gone from t
  /// on.
  FdsObstructions(const SmvIndex& index, double time);

  /// These alone.
  explicit FdsObstructions(std::vector<FdsBox> boxes);

  std::span<const FdsBox> boxes() const { return *boxes_; }

  /// Whether an obstruction lies between the ends of a finite segment. Ends may touch one: within 1
  /// mm of its ends a segment is free, so that a sign is seen on its wall. A ray that slides along
  /// a face is blocked.
  bool blocked(const Segment& segment) const;

  /// The same for many, on all cores; 1 where blocked.
  void blocked(std::span<const Segment> segments, std::span<std::uint8_t> out) const;

 private:
  struct Node {
    Box3 bounds;
    std::int32_t first = 0;  // of boxes, or of two child nodes
    std::int32_t count = 0;  // 0: an inner node
  };

  void build();
  void build(std::size_t node, std::size_t begin, std::size_t end);

  std::shared_ptr<std::vector<FdsBox>> boxes_;  // in the order of the tree's leaves
  std::shared_ptr<std::vector<Node>> nodes_;
};

/// Times at which an obstruction appears or goes [s], ascending, each once.
std::vector<double> obstructionEvents(const SmvIndex& index);

}  // namespace volute
