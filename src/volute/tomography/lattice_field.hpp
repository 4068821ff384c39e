// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "volute/tomography/support.hpp"
#include "volute/tomography/vector_ops.hpp"

namespace volute {

using Colour = Eigen::Array<float, 4, 1>;

/// Colours on the lattice of a support; zero where no unknown is. Neighbours stand support.stride()
/// apart: the layer of zeros around the box makes rows that follow each other in memory safe to run
/// through without a look at their ends.
class LatticeField {
 public:
  explicit LatticeField(const Support& support)
      : values_(support.latticeSize(), Colour::Zero()), nodes_(support.nodes()) {}

  void fill(std::span<const float> unknowns) {
    forElements(nodes_.size(), [&](std::size_t i) {
      values_[nodes_[i]] = Eigen::Map<const Colour>(&unknowns[4 * i]);
    });
  }

  void copyTo(std::span<float> unknowns) const {
    forElements(nodes_.size(), [&](std::size_t i) {
      Eigen::Map<Colour> to(&unknowns[4 * i]);
      to = values_[nodes_[i]];
    });
  }

  Colour& operator[](std::ptrdiff_t node) { return values_[node]; }

  const Colour& operator[](std::ptrdiff_t node) const { return values_[node]; }

 private:
  std::vector<Colour> values_;
  std::span<const std::int32_t> nodes_;
};

}  // namespace volute
