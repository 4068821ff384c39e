// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>
#include <vector>

#include "volute/wavelet/bspline.hpp"

namespace volute {

/// Coefficients c of sum c(j, i) N(x - i) N(y - j) on columns + d by rows + d cells, zero outside;
/// x and y in cells of the grid.
struct SplineGrid {
  int columns = 0;
  int rows = 0;
  std::vector<double> c;  ///< shape (rows, columns)

  SplineGrid() = default;

  SplineGrid(int columnCount, int rowCount)
      : columns(columnCount), rows(rowCount), c(static_cast<std::size_t>(columnCount) * rowCount) {}

  double& at(int i, int j) { return c[static_cast<std::size_t>(j) * columns + i]; }

  double at(int i, int j) const { return c[static_cast<std::size_t>(j) * columns + i]; }

  /// The same, with zeros all around.
  double orZero(int i, int j) const {
    return i < 0 || j < 0 || i >= columns || j >= rows ? 0 : at(i, j);
  }

  double sum() const;
};

/// How a grid becomes one of half the resolution. Along each axis n = cells / 2 - d coefficients
/// come out, with support inside the same domain. fine - prolonged(coarse) is the detail, so any of
/// them reconstructs perfectly.
enum class Restriction {
  kFullWeighting,  ///< P' / 2, as (1,2,1)/4: not negative, keeps the mass; blurs. For rendering
  kCdf,            ///< the low pass of shortestCdf(): FIR; undershoots
};

/// The coarse grid on a domain of columns + d by rows + d cells, both even, at least 2 (d + 1).
SplineGrid restricted(const SplineGrid& fine, int degree, Restriction restriction);

/// The same function on cells of half the side, exactly.
SplineGrid prolonged(const SplineGrid& coarse, int degree);

/// a - b.
SplineGrid difference(const SplineGrid& a, const SplineGrid& b);

/// Where a row of coefficients stands in a domain that can be halved `levels` times: centred, with
/// d cells of the coarsest level to spare on each side, so that no level loses mass at the border.
struct SplinePadding {
  int cells = 0;   ///< a multiple of 2^levels
  int offset = 0;  ///< the cell of the domain where the unpadded cells begin

  SplinePadding() = default;
  SplinePadding(int coefficients, int degree, int levels);
};

/// One function at several resolutions: level 0 is the finest, each further one has cells of twice
/// the side on the same domain. Each level is the approximation, not a detail: the sum of the
/// coarsest level and all finer details is what it holds (4/3 of the numbers of level 0).
class SplinePyramid {
 public:
  SplinePyramid() = default;

  /// The grid, padded on both axes, and `levels` restrictions of it.
  SplinePyramid(const SplineGrid& grid, int degree, int levels, Restriction restriction);

  int degree() const { return degree_; }

  /// How often it was halved.
  int levels() const { return static_cast<int>(grids_.size()) - 1; }

  const SplineGrid& level(int i) const { return grids_[i]; }

  const SplinePadding& paddingX() const { return x_; }

  const SplinePadding& paddingY() const { return y_; }

  /// level(i) - prolonged(level(i + 1)): the details that the step from i to i + 1 drops, in the
  /// splines of level i ("deconstructed", Giroud and Biri 2010, section 4.4).
  SplineGrid detail(int i) const;

  /// Two pyramids of the same grid sizes, mixed: (1 - share) * this + share * other.
  SplinePyramid mixed(const SplinePyramid& other, double share) const;

 private:
  int degree_ = 1;
  SplinePadding x_, y_;
  std::vector<SplineGrid> grids_;
};

}  // namespace volute
