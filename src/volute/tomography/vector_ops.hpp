// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "volute/base/parallel.hpp"

// Loops over long vectors on all threads, the same for any number of them.

namespace volute {

inline constexpr std::size_t kVectorBlock = 4096;

/// body(i) for each element.
template <class Body>
void forElements(std::size_t count, Body&& body) {
  parallelRanges(count, kVectorBlock, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) body(i);
  });
}

/// The sum of term(i), in double, added up in an order that depends on `count` alone.
template <class Term>
double sumElements(std::size_t count, Term&& term) {
  const std::size_t blocks = (count + kVectorBlock - 1) / kVectorBlock;
  std::vector<double> sums(blocks);
  parallelFor(blocks, [&](std::size_t block) {
    const std::size_t end = std::min(count, (block + 1) * kVectorBlock);
    double sum = 0;
    for (std::size_t i = block * kVectorBlock; i < end; ++i) sum += term(i);
    sums[block] = sum;
  });
  double sum = 0;
  for (double part : sums) sum += part;
  return sum;
}

inline double dot(std::span<const float> a, std::span<const float> b) {
  return sumElements(a.size(), [&](std::size_t i) { return static_cast<double>(a[i]) * b[i]; });
}

}  // namespace volute
