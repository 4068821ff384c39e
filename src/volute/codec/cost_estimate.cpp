// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/cost_estimate.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "volute/codec/subbands.hpp"

namespace volute {
namespace {

/// The synthesis norm of each coefficient of a block.
std::vector<float> normsOf(const BlockShape& shape, const BlockMode& mode) {
  const AxisLevels levels = blockLevels(shape.extents, mode.timeLevels);
  std::vector<float> norms(
      shape.voxels(), static_cast<float>(ScalingLattice(shape.extents, levels, mode.wavelet).norm));
  for (int stride = 0; stride < deepest(levels); ++stride) {
    const CellLevel level(shape.extents, levels, stride, mode.wavelet);
    BlockGrid::Index4 cell{};
    for (cell[0] = 0; cell[0] < level.cells[0]; ++cell[0])
      for (cell[1] = 0; cell[1] < level.cells[1]; ++cell[1])
        for (cell[2] = 0; cell[2] < level.cells[2]; ++cell[2]) {
          const std::uint16_t inRow = level.existingInRow({cell[0], cell[1], cell[2], 0});
          for (cell[3] = 0; cell[3] < level.cells[3]; ++cell[3]) {
            unsigned left = inRow;
            if (level.cut[3] && cell[3] == level.cells[3] - 1)
              left &= ~unsigned{level.high[3]};
            float* at = norms.data() + level.position(cell);
            for (; left != 0; left &= left - 1) {
              const int k = std::countr_zero(left);
              at[level.offset[k]] = static_cast<float>(level.norm[k]);
            }
          }
        }
  }
  return norms;
}

/// Of the shapes that came last: a file has few.
const std::vector<float>& keptNorms(const BlockShape& shape, const BlockMode& mode) {
  struct Kept {
    BlockGrid::Index4 extents{};
    Wavelet wavelet{};
    int timeLevels = -1;
    std::vector<float> norms;
  };

  thread_local std::array<Kept, 16> all;
  thread_local std::size_t next = 0;
  for (const Kept& kept : all) {
    if (kept.extents == shape.extents && kept.wavelet == mode.wavelet &&
        kept.timeLevels == mode.timeLevels)
      return kept.norms;
  }
  Kept& kept = all[next++ % all.size()];
  kept = {shape.extents, mode.wavelet, mode.timeLevels, normsOf(shape, mode)};
  return kept.norms;
}

}  // namespace

// A coefficient becomes the whole number near it or below it with the least cost: none costs its
// square, others the mean error of rounding and bits that grow with their logarithm.
CostEstimate::CostEstimate(const WaveletParameters& parameters, double lambda)
    : steps_(static_cast<float>(1 / parameters.step)) {
  constexpr double kBitsADoubling = 1.6;
  constexpr double kRounding = 0.1;
  const double ofOne = std::clamp(parameters.coefficientBits - 0.7, 3.0, 12.0);
  for (int i = 0; i < kCount; ++i) {
    const double size = std::exp2((i + 0.5) / 16 - 6);
    double cost = size * size;
    for (const double q : {std::floor(size), std::ceil(size)}) {
      const double error = size < 2 ? (size - q) * (size - q) : kRounding;
      if (q > 0)
        cost = std::min(cost, error + lambda * (ofOne + kBitsADoubling * std::log2(q)));
    }
    costs_[static_cast<std::size_t>(i)] = static_cast<std::uint32_t>(std::lround(kUnit * cost));
  }
  costs_[0] = 0;
}

double CostEstimate::of(std::span<const float> planes, const BlockShape& shape,
                        const BlockMode& mode) const {
  const std::vector<float>& norms = keptNorms(shape, mode);
  const std::size_t voxels = shape.voxels();
  std::uint64_t sum = 0;
  for (std::size_t begin = 0; begin < planes.size(); begin += voxels) {
    const float* plane = planes.data() + begin;
    for (std::size_t i = 0; i < voxels; ++i) {
      const float size = plane[i] * norms[i] * steps_;
      const auto bits = std::bit_cast<std::uint32_t>(size * size);
      const int at = std::clamp(static_cast<int>(bits >> kShift) - kFirst, 0, kCount - 1);
      sum += costs_[static_cast<std::size_t>(at)];
    }
  }
  return static_cast<double>(sum) / kUnit;
}

}  // namespace volute
