// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>

#include "volute/grid/brick_slice.hpp"

namespace volute {

/// Coefficients of a spline that is nearly as sharp as the values of the voxels: two steps of the
/// iteration c = v - (second differences of c) / 6, of which the fixed point's spline goes through
/// the values to the fourth order of the voxels' size. What one voxel gives its neighbours is at
/// most what it has: of values that are not negative none becomes so, what is empty stays so, and
/// the sum remains. Each brick has its own values.
BrickSlice splineThrough(const BrickSlice& values);

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
