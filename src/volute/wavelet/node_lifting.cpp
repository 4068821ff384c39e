// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/wavelet/node_lifting.hpp"

#include "volute/base/assert.hpp"

namespace volute {
namespace {

/// Even nodes += factor * (their odd neighbours); the first and the last node stay.
void updateEven(std::span<double> v, double factor) {
  const std::size_t last = v.size() - 1;
  for (std::size_t j = 2; j < last; j += 2) v[j] += factor * (v[j - 1] + v[j + 1]);
  if (last > 2) {
    v[2] += factor * v[1];
    v[last - 2] += factor * v[last - 1];
  }
}

void updateOdd(std::span<double> v, double factor) {
  for (std::size_t j = 1; j < v.size(); j += 2) v[j] += factor * (v[j - 1] + v[j + 1]);
}

}  // namespace

void liftNodes(std::span<double> nodes) {
  VOLUTE_ASSERT(nodes.size() % 2 == 1 && nodes.size() >= 3);
  updateOdd(nodes, -0.5);
  updateEven(nodes, 0.25);
}

void unliftNodes(std::span<double> nodes) {
  updateEven(nodes, -0.25);
  updateOdd(nodes, 0.5);
}

}  // namespace volute
