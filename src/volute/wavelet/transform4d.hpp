// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>

#include "volute/base/view.hpp"
#include "volute/wavelet/lifting.hpp"

namespace volute {

/// The 4D non-standard transform (Ahrenberg et al. 2005, section 4.1), in place, of any size: each
/// level lifts along x, y, z and t the samples that are low on all axes so far; they stand 2^level
/// apart, so the coefficients stay at the place that they describe. An axis takes part in its first
/// levels[axis] levels; an axis with one sample left is only scaled (by sqrt 2, like a sample
/// without a partner), so that scales agree between axes.
template <class T>
void transformForward(View<T, 4> samples, Wavelet wavelet, const std::array<int, 4>& levels);

/// Undoes transformForward with the same levels.
template <class T>
void transformInverse(View<T, 4> coefficients, Wavelet wavelet, const std::array<int, 4>& levels);

}  // namespace volute
