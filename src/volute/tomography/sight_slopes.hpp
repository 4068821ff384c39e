// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>

#include "volute/grid/traversal.hpp"
#include "volute/tomography/view.hpp"

namespace volute {

/// The line integral of a field, and its derivative with respect to the line: for a line o + t d
/// with d of length 1, the derivative along changes o', d' is alongOrigin . o' + alongDirection .
/// d'.
struct SightSlope {
  double integral = 0;  ///< of the field [value m]
  Vec3 alongOrigin = Vec3::Zero();
  Vec3 alongDirection = Vec3::Zero();
};

/// A field of one value a voxel, interpolated between voxel centres, zero one voxel beyond the
/// outer ones; by steps of half a voxel.
class SlopedField {
 public:
  /// @param values  (z, y, x).
  SlopedField(const VolumeGeometry& geometry, std::span<const float> values);

  SightSlope along(const Segment& sight) const;

 private:
  Vec3 cell_, origin_;  // of the padded lattice, whose first node has index 0
  std::array<int, 3> count_{};
  double step_;
  std::vector<float> values_;  // with one layer of zeros around
};

}  // namespace volute
