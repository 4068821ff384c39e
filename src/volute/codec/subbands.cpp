// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/subbands.hpp"

#include <algorithm>

namespace volute {

std::array<std::ptrdiff_t, 4> stridesOf(const BlockGrid::Index4& e) {
  return {std::ptrdiff_t{e[1]} * e[2] * e[3], std::ptrdiff_t{e[2]} * e[3], e[3], 1};
}

CellLevel::CellLevel(const Index4& extents, const AxisLevels& levels, int j, Wavelet wavelet)
    : stride(j) {
  const auto strides = stridesOf(extents);
  orientations = 0xFFFE;
  norm.fill(1);
  for (int axis = 0; axis < 4; ++axis) {
    halved[axis] = j < levels[axis];
    const int before = std::min(j, levels[axis]);
    const int samples = (extents[axis] + (1 << before) - 1) >> before;
    cells[axis] = halved[axis] ? (samples + 1) / 2 : samples;
    cut[axis] = halved[axis] && samples % 2 == 1;
    step[axis] = strides[axis] << (before + (halved[axis] ? 1 : 0));
    const int bit = 8 >> axis;
    for (int k = 0; k < 16; ++k) {
      if ((k & bit) == 0) {
        norm[k] *= synthesisNorm(wavelet, before + (halved[axis] ? 1 : 0), false);
        continue;
      }
      high[axis] = static_cast<std::uint16_t>(high[axis] | 1 << k);
      offset[k] += static_cast<int>(strides[axis] << before);
      if (halved[axis])
        norm[k] *= synthesisNorm(wavelet, before + 1, true);
    }
    if (!halved[axis])
      orientations = static_cast<std::uint16_t>(orientations & ~high[axis]);
  }
}

ScalingLattice::ScalingLattice(const BlockGrid::Index4& extents, const AxisLevels& levels,
                               Wavelet wavelet) {
  const auto strides = stridesOf(extents);
  for (int axis = 0; axis < 4; ++axis) {
    count[axis] = (extents[axis] + (1 << levels[axis]) - 1) >> levels[axis];
    step[axis] = strides[axis] << levels[axis];
    norm *= synthesisNorm(wavelet, levels[axis], false);
  }
}

}  // namespace volute
