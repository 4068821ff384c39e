// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>

#include "volute/geometry/triangle_scene.hpp"

namespace volute {

/// A segment made ready to meet many triangles: Woop, Benthin and Wald, "Watertight ray/triangle
/// intersection" (2013), in double. The three edge functions of a triangle are those of its
/// neighbours with the other sign, to the last bit, so that nothing slips between them.
class SegmentTest {
 public:
  explicit SegmentTest(const Segment& segment);

  /// The segment's parameter at the triangle, if it lies strictly between begin and end. A triangle
  /// that is seen edge-on is not met.
  std::optional<double> meets(const Triangle& triangle) const;

 private:
  Segment segment_;
  int x_ = 0, y_ = 1, z_ = 2;  ///< axes, z_ along the largest part of the direction
  double shearX_ = 0, shearY_ = 0, scaleZ_ = 1;
};

}  // namespace volute
