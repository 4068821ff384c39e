// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/math/rotation.hpp"
#include "volute/math/vec.hpp"

namespace volute {

/// The shortest turn that takes the z axis to `up`, which is not 0 and need not be of length 1.
/// Half a turn about x where `up` points down.
Mat3 turnOfZ(const Vec3& up);

/// @param axis  of length 1
/// @param angle  [rad], counterclockwise when seen from where the axis points to
Mat3 turnAbout(const Vec3& axis, double angle);

/// @param quaternion  x, y, z, w of any length but 0
Mat3 turnOfQuaternion(const Vec4& quaternion);

/// The rotation of the polar decomposition of a matrix of positive determinant, the nearest to it
/// (Higham, Computing the polar decomposition, SIAM J. Sci. Stat. Comput. 7, 1986, eq. 2.1).
Mat3 nearestRotation(const Mat3& matrix);

}  // namespace volute
