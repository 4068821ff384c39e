// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>

#include "volute/grid/brick_slice.hpp"

namespace volute {

/// The spline of a slice over Basis::kCubic as trilinear voxels of half the size, which the fast
/// march and OpenGL draw. The voxels are not the spline's values but those whose line integrals are
/// the spline's to the fourth order; they are sums of coefficients with positive weights.
/// The slice is 2 n + 5 voxels of half the size long, since splines reach beyond their voxels.
BrickSlice refinedSpline(const BrickSlice& spline);

/// The same on voxels of the same size, n + 2 long: for light on its way, which needs less.
BrickSlice smoothedSpline(const BrickSlice& spline);

/// What refinedSpline() and a march grid of it take at most [bytes].
std::uint64_t refinedSplineBytes(const BrickSlice& spline);

}  // namespace volute
