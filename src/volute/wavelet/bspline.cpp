// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/wavelet/bspline.hpp"

#include <algorithm>
#include <cmath>

#include "volute/base/assert.hpp"

namespace volute {
namespace {

double binomial(int n, int k) {
  double value = 1;
  for (int i = 1; i <= k; ++i) value = value * (n - k + i) / i;
  return value;
}

std::vector<double> scaled(std::vector<double> values, double factor) {
  for (double& value : values) value *= factor;
  return values;
}

}  // namespace

double bspline(int degree, double x) {
  VOLUTE_ASSERT(degree >= 0 && degree <= 7);
  if (!(x >= 0 && x < degree + 1))
    return 0;
  // De Boor's recurrence over the splines that touch x, without cancellation.
  const int cell = static_cast<int>(x);
  const double u = x - cell;
  std::array<double, 9> value{};  // value[j] = N of the current degree at u + j
  value[0] = 1;
  for (int d = 1; d <= degree; ++d) {
    for (int j = d; j >= 0; --j) {
      const double here = j < d ? (u + j) * value[j] : 0;
      const double before = j > 0 ? (d + 1 - u - j) * value[j - 1] : 0;
      value[j] = (here + before) / d;
    }
  }
  return value[cell];
}

std::vector<double> twoScale(int degree) {
  std::vector<double> p;
  for (int k = 0; k <= degree + 1; ++k) p.push_back(binomial(degree + 1, k) / std::exp2(degree));
  return p;
}

SplinePieces splinePieces(int degree) {
  switch (degree) {
    case 0:
      return {{{1}}};
    case 1:
      return {{{1, -1}, {0, 1}}};
    case 2:
      return {{{0.5, -1, 0.5}, {0.5, 1, -1}, {0, 0, 0.5}}};
    default:
      VOLUTE_ASSERT(degree == 3);
      return {{{1 / 6.0, -0.5, 0.5, -1 / 6.0},
               {2 / 3.0, 0, -1, 0.5},
               {1 / 6.0, 0.5, 0.5, -0.5},
               {0, 0, 0, 1 / 6.0}}};
  }
}

std::array<double, 4> splineWeights(int degree, double u) {
  const SplinePieces pieces = splinePieces(degree);
  std::array<double, 4> weights{};
  for (int i = 0; i <= degree; ++i) {
    const auto& p = pieces[i];
    weights[i] = p[0] + u * (p[1] + u * (p[2] + u * p[3]));
  }
  return weights;
}

const std::vector<CdfFilters>& cdfFilters() {
  static const std::vector<CdfFilters> table = {
      {0, 1, {1, -1}, {0.5, 0.5}, {0.5, -0.5}, 0, 0, 0},
      {1,
       2,
       scaled({-1, -2, 6, -2, -1}, 1 / 8.0),
       scaled({-1, 2, 6, 2, -1}, 1 / 8.0),
       {-0.5, 1, -0.5},
       0,
       -1,
       1},
      {2, 1, scaled({-1, -3, 3, 1}, 1 / 4.0), scaled({-1, 3, 3, -1}, 1 / 4.0),
       scaled({1, -3, 3, -1}, 1 / 4.0), 0, 0, 0},
      {2, 3, scaled({3, 9, -7, -45, 45, 7, -9, -3}, 1 / 64.0),
       scaled({3, -9, -7, 45, 45, -7, -9, 3}, 1 / 64.0), scaled({1, -3, 3, -1}, 1 / 4.0), -2, -2,
       0},
      {3, 2, scaled({3, 12, 5, -40, 5, 12, 3}, 1 / 32.0),
       scaled({3, -12, 5, 40, 5, -12, 3}, 1 / 32.0), scaled({-1, 4, -6, 4, -1}, 1 / 8.0), 0, -1,
       1}};
  return table;
}

const CdfFilters& shortestCdf(int degree) {
  return *std::ranges::find(cdfFilters(), degree, &CdfFilters::degree);
}

}  // namespace volute
