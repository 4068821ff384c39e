// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>
#include <vector>

#include "volute/tomography/projector.hpp"

namespace volute {

/// The projector's twin: scalar, in double, ray by ray, over the whole volume without a hull.
class ReferenceProjector {
 public:
  ReferenceProjector(const VolumeGeometry& geometry, Basis basis)
      : geometry_(geometry), basis_(basis), cells_(basisCells(geometry, basis)) {}

  /// The integral along a segment of one channel, `values` of shape (z, y, x).
  double forward(std::span<const double> values, const Segment& segment) const;

  /// gradient += weight * (the row of the segment).
  void adjoint(double weight, const Segment& segment, std::span<double> gradient) const;

 private:
  VolumeGeometry geometry_;
  Basis basis_;
  CellGrid cells_;
};

}  // namespace volute
