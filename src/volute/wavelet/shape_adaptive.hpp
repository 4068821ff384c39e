// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "volute/wavelet/lifting.hpp"

// Lifting on a support of any shape (after Li and Li, "Shape-adaptive discrete wavelet transforms",
// 2000). Samples outside the support are zero and stay zero; a neighbour that is not in the support
// is mirrored by the other one, and a sample without neighbours is a scaling coefficient (times
// sqrt 2) at an even place and a wavelet coefficient, as it is, at an odd one. On a full support it
// is the symmetric extension of liftForward().
//
// Additions and multiplications are done one by one in float32, in the same order on every
// CPU, so results are the same bits everywhere: a codec relies on it.

namespace volute {

/// The longest side of a block.
inline constexpr int kLongestSide = 16;

/// How often each axis of a block is halved. Axes are (t, z, y, x).
using AxisLevels = std::array<int, 4>;

/// Levels of the space axes until each has one sample; of time as many as asked for, and no more
/// than there is to halve.
AxisLevels blockLevels(const std::array<int, 4>& extents, int timeLevels);

/// The greatest of them.
int deepest(const AxisLevels& levels);

/// The non-standard 4D transform of a block, in place and interleaved (as transformForward).
///
/// @param samples  shape `extents`, each side 1 to kLongestSide; outside of the support they must
///   be zero.
/// @param support  1 for samples of the support, else 0; same shape, or empty for all.
void shapeForward(std::span<float> samples, std::span<const std::uint8_t> support,
                  const std::array<int, 4>& extents, Wavelet wavelet, const AxisLevels& levels);

/// Undoes shapeForward up to rounding, given the same support. Coefficients outside it must be
/// zero.
/// @param first, end  the samples wanted on the first axis; what the others hold is not said
void shapeInverse(std::span<float> coefficients, std::span<const std::uint8_t> support,
                  const std::array<int, 4>& extents, Wavelet wavelet, const AxisLevels& levels,
                  int first = 0, int end = kLongestSide);

/// The same of one line, sample by sample: the twin that the fast ones are tested against.
void shapeForwardLine(std::span<float> samples, std::span<const std::uint8_t> support,
                      Wavelet wavelet);
void shapeInverseLine(std::span<float> coefficients, std::span<const std::uint8_t> support,
                      Wavelet wavelet);

/// The root of the sum of squares that a unit coefficient makes of samples on one axis, far from
/// the borders: after `levels` halvings the scaling function's, or the wavelet's of the last of
/// them. levels 0 to 4; 1 for no halving.
double synthesisNorm(Wavelet wavelet, int levels, bool high);

}  // namespace volute
