// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <vector>

namespace volute {

// Cardinal B-splines of degree d, order m = d + 1: N(x) has support [0, m], knots at the integers,
// integral 1, and its shifts by integers sum to 1.

constexpr int kMaxSplineDegree = 3;

/// N(x) of any degree from 0 to 7. Degree 0 is 1 on [0, 1).
double bspline(int degree, double x);

/// The two-scale sequence p_k = C(m, k) / 2^d, k = 0..m: N(x) = sum of p_k N(2x - k).
/// (Giroud and Biri 2010, section 3.1; no factor sqrt 2.)
std::vector<double> twoScale(int degree);

/// The m splines that touch the cell [0, 1], the one that begins first at i = 0:
/// N(u + d - i) = sum over a of pieces[i][a] u^a. Rows and columns beyond d are zero.
using SplinePieces = std::array<std::array<double, 4>, 4>;
SplinePieces splinePieces(int degree);

/// The values of those m splines at u in [0, 1].
std::array<double, 4> splineWeights(int degree, double u);

/// A biorthogonal pair (Cohen, Daubechies, Feauveau): FIR both ways.
///   fine = sum of coarse_k p_(n-2k) + detail_k wavelet_(n-2k-waveletFirst)
///   coarse_k = sum of low_i fine_(2k+lowFirst+i),  detail_k = sum of high_i fine_(2k+highFirst+i)
struct CdfFilters {
  int degree = 0;
  int vanishingMoments = 1;
  std::vector<double> wavelet, low, high;
  int waveletFirst = 0, lowFirst = 0, highFirst = 0;
};

/// CDF(1,1) = Haar, (2,2), (3,1), (3,3), (4,2); the first of a degree is the one with the shortest
/// filters.
const std::vector<CdfFilters>& cdfFilters();

/// The first entry of that degree.
const CdfFilters& shortestCdf(int degree);

}  // namespace volute
