// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <Eigen/Core>

namespace volute {

/// Points and directions in the world [m] unless a name says otherwise (pointInVoxels,
/// pointInCamera).
using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Mat4 = Eigen::Matrix4d;

/// Linear RGB: radiance, or whatever a comment says.
using Rgb = Eigen::Array3d;

}  // namespace volute
