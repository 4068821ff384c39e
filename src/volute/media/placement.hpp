// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/base/result.hpp"
#include "volute/math/vec.hpp"
#include "volute/media/field.hpp"

namespace volute {

/// Where a volume stands in a scene: every point is scaled along the axes, then turned about the
/// origin, then moved.
struct Placement {
  Vec3 scale = Vec3::Ones();  ///< > 0
  Vec3 offset = Vec3::Zero();
  Mat3 turn = Mat3::Identity();  ///< orthogonal; may mirror

  bool turns() const { return turn != Mat3::Identity(); }
};

/// 16 numbers, row-major: an affine transform that can be undone. Errors have no place.
[[nodiscard]] Result<Mat4> transformFrom(const FieldValue& numbers);
FieldValue transformValue(const Mat4& matrix);

/// The same of a volume, whose voxels stay at right angles: kUnsupported for a transform that
/// shears.
[[nodiscard]] Result<Placement> placementFrom(const FieldValue& numbers);

}  // namespace volute
