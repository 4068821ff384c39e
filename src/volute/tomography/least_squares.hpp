// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "volute/tomography/projector.hpp"

namespace volute {

/// min 1/2 |W (S a - measured)|^2: the data of one frame. Vectors as the projector has them.
struct LeastSquares {
  const Projector* projector = nullptr;
  std::vector<float> measured;       ///< p - b, four floats for each row
  std::vector<float> squaredWeight;  ///< one for each row; 0 for pixels that are held out
  /// One for each row, bit c: channel c was `measured` or more, and costs nothing above. Empty:
  /// none. For solvers that go by gradient() alone.
  std::vector<std::uint8_t> atLeast{};

  /// One for each row, 1: what was measured is the mean of the three channels. Empty: none. For
  /// solvers that go by gradient() alone.
  std::vector<std::uint8_t> grey{};

  std::size_t unknowns() const { return projector->unknowns(); }

  std::size_t rows() const { return projector->rows(); }

  /// projected - measured of element i, 4 for each row; 0 for what is above a bound.
  /// @param row  the row's four values of what is projected
  float misfit(std::size_t i, const float* row) const {
    const bool mean = !grey.empty() && grey[i / 4] != 0 && i % 4 < 3;
    const float difference = (mean ? (row[0] + row[1] + row[2]) / 3 : row[i % 4]) - measured[i];
    const bool bound = !atLeast.empty() && (atLeast[i / 4] >> (i % 4) & 1) != 0;
    return bound && difference > 0 ? 0 : difference;
  }

  /// gradient = S' W^2 (projected - measured), given projected = S a.
  void gradient(std::span<const float> projected, std::span<float> gradient) const;

  /// projected = S a and the gradient there, in one walk.
  void projectAndGradient(std::span<const float> a, std::span<float> projected,
                          std::span<float> gradient) const;

  /// |W (projected - measured)|^2.
  double squaredResidual(std::span<const float> projected) const;

  /// S' W^2 S 1, one for each unknown: a diagonal matrix no smaller than S' W^2 S, as no entry of S
  /// is negative.
  std::vector<float> majorizer() const;

  /// The largest eigenvalue of S' W^2 S [m^2], by power iteration: too small by some percent at
  /// most.
  double largestEigenvalue() const;
};

}  // namespace volute
