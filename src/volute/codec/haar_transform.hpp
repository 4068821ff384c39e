// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "volute/codec/block_grid.hpp"

namespace volute {

/// The non-standard 4D Haar transform in averages form, in place, of any extents (Ahrenberg et al.
/// 2005, section 4.1; docs/format.md, section 7). Stride 2^j makes level levels-1-j; its
/// coefficients stand where the low ones of that stride do not. A sample without a partner is its
/// own average.
void haarForward(std::span<float> samples, const BlockGrid::Index4& extents);

/// Undoes haarForward up to rounding.
void haarInverse(std::span<float> coefficients, const BlockGrid::Index4& extents);

/// Where the coefficients of one stride stand: cells at multiples of twice the stride, each with up
/// to 15 coefficients.
class HaarCells {
 public:
  HaarCells(const BlockGrid::Index4& extents, int j) : extents_(extents), stride_(1 << j) {
    std::ptrdiff_t step[4] = {0, 0, 0, stride_};
    for (int axis = 2; axis >= 0; --axis) step[axis] = step[axis + 1] * extents[axis + 1];
    for (unsigned k = 0; k < 16; ++k) {
      for (unsigned axis = 0; axis < 4; ++axis) {
        if (k >> (3 - axis) & 1)
          offsets_[k] += step[axis];
      }
    }
    // Which coefficients exist where only the axes in `present` have a partner: those that need no
    // other.
    for (unsigned present = 0; present < 16; ++present) {
      for (unsigned k = 1; k < 16; ++k) {
        if ((k & ~present) == 0)
          exist_[present] |= static_cast<std::uint16_t>(1u << k);
      }
    }
  }

  std::size_t count() const {
    std::size_t count = 1;
    for (int side : extents_)
      count *= static_cast<std::size_t>((side + 2 * stride_ - 1) / (2 * stride_));
    return count;
  }

  /// Where coefficient k stands, from its cell.
  std::ptrdiff_t offset(unsigned k) const { return offsets_[k]; }

  /// Calls visit(position, mask of existing coefficients, part of the cell that lies inside the
  /// block) for each cell in order; stops when it returns false.
  template <class Visit>
  void visit(const Visit& visit) const {
    const int cell = 2 * stride_;
    for (int t = 0; t < extents_[0]; t += cell) {
      for (int z = 0; z < extents_[1]; z += cell) {
        for (int y = 0; y < extents_[2]; y += cell) {
          const unsigned outer = partner(t, 0) << 3 | partner(z, 1) << 2 | partner(y, 2) << 1;
          const double part = inside(t, 0) * inside(z, 1) * inside(y, 2);
          const std::ptrdiff_t line =
              ((static_cast<std::ptrdiff_t>(t) * extents_[1] + z) * extents_[2] + y) * extents_[3];
          for (int x = 0; x < extents_[3]; x += cell) {
            if (!visit(line + x, exist_[outer | partner(x, 3)], part * inside(x, 3)))
              return;
          }
        }
      }
    }
  }

 private:
  unsigned partner(int position, int axis) const {
    return position + stride_ < extents_[axis] ? 1 : 0;
  }

  double inside(int position, int axis) const {
    return static_cast<double>(std::min(2 * stride_, extents_[axis] - position)) / (2 * stride_);
  }

  BlockGrid::Index4 extents_;
  int stride_;
  std::array<std::ptrdiff_t, 16> offsets_{};
  std::array<std::uint16_t, 16> exist_{};
};

}  // namespace volute
