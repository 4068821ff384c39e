// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/wavelet/spline_pyramid.hpp"

#include <algorithm>
#include <numeric>

#include "volute/base/assert.hpp"

namespace volute {
namespace {

// All steps run along the row index, over whole rows of columns: the inner loops are contiguous.
// The other axis is done on the transposed grid.

SplineGrid transposed(const SplineGrid& grid) {
  SplineGrid out(grid.rows, grid.columns);
  constexpr int kTile = 16;
  for (int j0 = 0; j0 < grid.rows; j0 += kTile) {
    for (int i0 = 0; i0 < grid.columns; i0 += kTile) {
      for (int i = i0; i < std::min(i0 + kTile, grid.columns); ++i) {
        for (int j = j0; j < std::min(j0 + kTile, grid.rows); ++j) out.at(j, i) = grid.at(i, j);
      }
    }
  }
  return out;
}

/// Row j of `out` += factor * row k of `in`; rows that are not there are zero.
void addRow(SplineGrid& out, int j, double factor, const SplineGrid& in, int k) {
  if (k < 0 || k >= in.rows || j < 0 || j >= out.rows)
    return;
  double* to = &out.at(0, j);
  const double* from = &in.c[static_cast<std::size_t>(k) * in.columns];
  for (int i = 0; i < in.columns; ++i) to[i] += factor * from[i];
}

int coarseCount(int fine, int degree) {
  VOLUTE_ASSERT((fine + degree) % 2 == 0 && (fine + degree) / 2 > degree);
  return (fine + degree) / 2 - degree;
}

/// Coarse row k = sum of taps_i * fine row 2k + first + i.
SplineGrid filterRows(const SplineGrid& fine, int degree, std::span<const double> taps, int first) {
  SplineGrid coarse(fine.columns, coarseCount(fine.rows, degree));
  for (int k = 0; k < coarse.rows; ++k) {
    for (std::size_t i = 0; i < taps.size(); ++i)
      addRow(coarse, k, taps[i], fine, 2 * k + first + static_cast<int>(i));
  }
  return coarse;
}

std::vector<double> scaledTwoScale(int degree, double factor) {
  std::vector<double> p = twoScale(degree);
  for (double& tap : p) tap *= factor;
  return p;
}

SplineGrid restrictedRows(const SplineGrid& fine, int degree, Restriction restriction) {
  if (restriction == Restriction::kFullWeighting)
    return filterRows(fine, degree, scaledTwoScale(degree, 0.5), 0);
  const CdfFilters& filters = shortestCdf(degree);
  return filterRows(fine, degree, filters.low, filters.lowFirst);
}

SplineGrid prolongedRows(const SplineGrid& coarse, int degree) {
  SplineGrid fine(coarse.columns, 2 * coarse.rows + degree);
  const std::vector<double> p = twoScale(degree);
  for (int k = 0; k < coarse.rows; ++k) {
    for (int i = 0; i <= degree + 1; ++i) addRow(fine, 2 * k + i, p[i], coarse, k);
  }
  return fine;
}

SplineGrid padded(const SplineGrid& grid, int degree, const SplinePadding& x,
                  const SplinePadding& y) {
  SplineGrid out(x.cells - degree, y.cells - degree);
  for (int j = 0; j < grid.rows; ++j) {
    std::copy_n(&grid.c[static_cast<std::size_t>(j) * grid.columns], grid.columns,
                &out.at(x.offset, j + y.offset));
  }
  return out;
}

}  // namespace

double SplineGrid::sum() const {
  return std::accumulate(c.begin(), c.end(), 0.0);
}

SplineGrid restricted(const SplineGrid& fine, int degree, Restriction restriction) {
  const SplineGrid half = transposed(restrictedRows(fine, degree, restriction));
  return transposed(restrictedRows(half, degree, restriction));
}

SplineGrid prolonged(const SplineGrid& coarse, int degree) {
  return transposed(prolongedRows(transposed(prolongedRows(coarse, degree)), degree));
}

SplineGrid difference(const SplineGrid& a, const SplineGrid& b) {
  VOLUTE_ASSERT(a.columns == b.columns && a.rows == b.rows);
  SplineGrid out = a;
  for (std::size_t i = 0; i < out.c.size(); ++i) out.c[i] -= b.c[i];
  return out;
}

SplinePadding::SplinePadding(int coefficients, int degree, int levels) {
  const int wanted = coefficients + degree;
  const int step = 1 << levels;
  const int spare = levels > 0 ? degree * step : 0;
  cells = (wanted + step - 1) / step * step + 2 * spare;
  offset = (cells - wanted) / 2;
}

SplinePyramid::SplinePyramid(const SplineGrid& grid, int degree, int levels,
                             Restriction restriction)
    : degree_(degree), x_(grid.columns, degree, levels), y_(grid.rows, degree, levels) {
  grids_.push_back(padded(grid, degree, x_, y_));
  for (int i = 0; i < levels; ++i) grids_.push_back(restricted(grids_[i], degree, restriction));
}

SplineGrid SplinePyramid::detail(int i) const {
  return difference(grids_[i], prolonged(grids_[i + 1], degree_));
}

SplinePyramid SplinePyramid::mixed(const SplinePyramid& other, double share) const {
  VOLUTE_ASSERT(levels() == other.levels());
  SplinePyramid out = *this;
  for (int i = 0; i <= levels(); ++i) {
    auto& mine = out.grids_[i].c;
    const auto& theirs = other.grids_[i].c;
    VOLUTE_ASSERT(mine.size() == theirs.size());
    for (std::size_t k = 0; k < mine.size(); ++k) mine[k] += share * (theirs[k] - mine[k]);
  }
  return out;
}

}  // namespace volute
