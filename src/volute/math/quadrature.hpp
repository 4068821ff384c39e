// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cmath>
#include <functional>
#include <span>

namespace volute {

/// Nodes on (-1, 1) and weights that sum to 2 of the Gauss-Legendre rule; exact for degree 2n - 1.
struct GaussRule {
  std::span<const double> nodes;
  std::span<const double> weights;
};

/// n = 1 to 5, or 8.
GaussRule gaussRule(int n);

/// The integral of `f` over [a, b] by an n-point Gauss rule.
template <class F>
auto gaussIntegral(int n, double a, double b, F&& f) {
  const GaussRule rule = gaussRule(n);
  const double half = 0.5 * (b - a);
  const double middle = 0.5 * (a + b);
  auto sum = rule.weights[0] * f(middle + half * rule.nodes[0]);
  for (std::size_t i = 1; i < rule.nodes.size(); ++i)
    sum = sum + rule.weights[i] * f(middle + half * rule.nodes[i]);
  return decltype(sum)(sum * half);
}

/// The integral of `f` over [a, b] by adaptive Simpson to about `tolerance` (absolute); splits at
/// most `depth` times, so it ends on jumps too, with an error of about |jump| * (b - a) / 2^depth.
double adaptiveIntegral(const std::function<double(double)>& f, double a, double b,
                        double tolerance, int depth = 24);

}  // namespace volute
