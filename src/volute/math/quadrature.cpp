// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/math/quadrature.hpp"

#include <array>

#include "volute/base/assert.hpp"

namespace volute {
namespace {

// Abramowitz and Stegun, table 25.4.
constexpr std::array kNodes1{0.0};
constexpr std::array kWeights1{2.0};
constexpr std::array kNodes2{-0.5773502691896257645, 0.5773502691896257645};
constexpr std::array kWeights2{1.0, 1.0};
constexpr std::array kNodes3{-0.7745966692414833770, 0.0, 0.7745966692414833770};
constexpr std::array kWeights3{5.0 / 9, 8.0 / 9, 5.0 / 9};
constexpr std::array kNodes4{-0.8611363115940525752, -0.3399810435848562648, 0.3399810435848562648,
                             0.8611363115940525752};
constexpr std::array kWeights4{0.3478548451374538574, 0.6521451548625461426, 0.6521451548625461426,
                               0.3478548451374538574};
constexpr std::array kNodes5{-0.9061798459386639928, -0.5384693101056830910, 0.0,
                             0.5384693101056830910, 0.9061798459386639928};
constexpr std::array kWeights5{0.2369268850561890875, 0.4786286704993664680, 0.5688888888888888889,
                               0.4786286704993664680, 0.2369268850561890875};
constexpr std::array kNodes8{-0.9602898564975362317, -0.7966664774136267396, -0.5255324099163289858,
                             -0.1834346424956498049, 0.1834346424956498049,  0.5255324099163289858,
                             0.7966664774136267396,  0.9602898564975362317};
constexpr std::array kWeights8{0.1012285362903762591, 0.2223810344533744705, 0.3137066458778872873,
                               0.3626837833783619830, 0.3626837833783619830, 0.3137066458778872873,
                               0.2223810344533744705, 0.1012285362903762591};

double simpson(double fa, double fm, double fb, double width) {
  return width / 6 * (fa + 4 * fm + fb);
}

double refine(const std::function<double(double)>& f, double a, double b, double fa, double fm,
              double fb, double whole, double tolerance, int depth) {
  const double m = 0.5 * (a + b);
  const double fl = f(0.5 * (a + m));
  const double fr = f(0.5 * (m + b));
  const double left = simpson(fa, fl, fm, m - a);
  const double right = simpson(fm, fr, fb, b - m);
  if (depth <= 0 || std::abs(left + right - whole) <= 15 * tolerance)
    return left + right + (left + right - whole) / 15;
  return refine(f, a, m, fa, fl, fm, left, 0.5 * tolerance, depth - 1) +
         refine(f, m, b, fm, fr, fb, right, 0.5 * tolerance, depth - 1);
}

}  // namespace

GaussRule gaussRule(int n) {
  switch (n) {
    case 1:
      return {kNodes1, kWeights1};
    case 2:
      return {kNodes2, kWeights2};
    case 3:
      return {kNodes3, kWeights3};
    case 4:
      return {kNodes4, kWeights4};
    case 5:
      return {kNodes5, kWeights5};
    default:
      VOLUTE_ASSERT(n == 8);
      return {kNodes8, kWeights8};
  }
}

double adaptiveIntegral(const std::function<double(double)>& f, double a, double b,
                        double tolerance, int depth) {
  if (!(a < b))
    return 0;
  // A first cut into eight keeps narrow features from hiding between the five first samples.
  constexpr int kFirstCut = 8;
  double sum = 0;
  for (int i = 0; i < kFirstCut; ++i) {
    const double l = a + (b - a) * i / kFirstCut;
    const double r = a + (b - a) * (i + 1) / kFirstCut;
    const double fl = f(l), fm = f(0.5 * (l + r)), fr = f(r);
    sum += refine(f, l, r, fl, fm, fr, simpson(fl, fm, fr, r - l), tolerance / kFirstCut, depth);
  }
  return sum;
}

}  // namespace volute
