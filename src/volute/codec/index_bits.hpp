// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <cstdlib>

#include "volute/codec/arithmetic_coder.hpp"

namespace volute {

/// The greatest index of a probability in a table; the least is 1.
inline constexpr int kGreatestIndex = 63;

/// How a table has an index, as its difference from the last: whether it stays, else whether it is
/// less, and by how much, in unary.
struct IndexBits {
  AdaptiveBit zero, negative, longer[8];

  AdaptiveBit& longerThan(int size) { return longer[std::min(size, 8) - 1]; }

  void write(ArithmeticEncoder& out, int difference) {
    out.bit(zero, difference == 0);
    if (difference == 0)
      return;
    out.bit(negative, difference < 0);
    for (int i = 1; i < kGreatestIndex; ++i) {
      const bool more = std::abs(difference) > i;
      out.bit(longerThan(i), more);
      if (!more)
        break;
    }
  }

  /// The index after the last one. Any bits give one.
  int read(ArithmeticDecoder& in, int last) {
    if (in.bit(zero))
      return last;
    const bool less = in.bit(negative);
    int size = 1;
    while (size < kGreatestIndex && in.bit(longerThan(size))) ++size;
    return std::clamp(last + (less ? -size : size), 1, kGreatestIndex);
  }
};

}  // namespace volute
