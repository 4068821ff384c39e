// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/solvers.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "volute/tomography/vector_ops.hpp"

namespace volute {
namespace {

using Vector = std::vector<float>;

/// 1 / a[i] where that makes sense, else 0.
void invert(Vector& a) {
  float largest = 0;
  for (float value : a) largest = std::max(largest, value);
  const float least = 1e-6F * largest;
  forElements(a.size(), [&](std::size_t i) { a[i] = a[i] > least ? 1 / a[i] : 0; });
}

Vector constantVector(std::size_t count, float value) {
  Vector a(4 * count, value);
  for (std::size_t i = 3; i < a.size(); i += 4) a[i] = 0;
  return a;
}

/// S' W^2 1.
Vector columnSums(const LeastSquares& problem) {
  Vector ones(4 * problem.rows());
  forElements(ones.size(),
              [&](std::size_t i) { ones[i] = i % 4 == 3 ? 0 : problem.squaredWeight[i / 4]; });
  Vector sums(4 * problem.unknowns());
  problem.projector->adjoint(ones, sums);
  return sums;
}

/// 1 / curvature for each unknown.
std::vector<float> steps(const LeastSquares& problem, double largest, const Prior& prior) {
  constexpr double kSafety = 1.02;  // the power iteration comes from below
  const auto smooth = static_cast<float>(prior.curvature());
  if (!prior.takesSteps())
    return std::vector<float>(problem.unknowns(),
                              1 / (static_cast<float>(kSafety * largest) + smooth));
  std::vector<float> step = problem.majorizer();
  // Unknowns that hardly any ray reaches must not run away with rounding.
  const auto least = static_cast<float>(1e-4 * largest);
  for (float& value : step) value = 1 / (std::max(value, least) + smooth);
  return step;
}

std::array<double, 3> channelNorms(const Vector& a) {
  std::array<double, 3> sums{};
  for (std::size_t c = 0; c < 3; ++c)
    sums[c] = sumElements(a.size() / 4, [&](std::size_t i) {
      const double value = a[4 * i + c];
      return value * value;
    });
  return sums;
}

}  // namespace

int solveApg(const LeastSquares& problem, double largest, Prior& prior, int iterations,
             Vector& unknowns, const SolverWatch& watch) {
  const std::vector<float> step = steps(problem, largest, prior);
  Vector& x = unknowns;
  Vector before = x, descended = x, ahead = x, whole = x, gradient(x.size());
  Vector sx(4 * problem.rows());
  std::vector<float> length(step.size());
  double weight = 1, reach = 1;  // theta and L gamma of the paper
  for (int k = 1; k <= iterations; ++k) {
    problem.projectAndGradient(x, sx, gradient);
    if (k > 1 && !watch(k - 1, x, sx))
      return k - 1;
    prior.addGradient(x, gradient);
    const double next = 0.5 * (1 + std::sqrt(1 + 4 * weight * weight));
    const auto along = static_cast<float>((weight - 1) / next),
               over = static_cast<float>(weight / next),
               back = static_cast<float>((weight - 1) / (reach * next));
    reach = (2 * weight + next - 1) / next;
    forElements(step.size(),
                [&](std::size_t i) { length[i] = static_cast<float>(reach) * step[i]; });
    std::swap(before, x);
    forElements(x.size(), [&](std::size_t i) {
      const float down = before[i] - step[i / 4] * gradient[i];
      ahead[i] = down + along * (down - descended[i]) + over * (down - before[i]) +
                 back * (ahead[i] - before[i]);
      descended[i] = down;
      x[i] = ahead[i];
    });
    prior.proximal(x, length);
    const double uphill = sumElements(x.size(), [&](std::size_t i) {
      const float slope = gradient[i] + (ahead[i] - x[i]) / length[i / 4];  // the prior's too
      const float moved = before[i] - step[i / 4] * slope;
      return static_cast<double>(slope) * (moved - std::exchange(whole[i], moved));
    });
    weight = uphill > 0 && k > 1 ? 1 : next;
  }
  problem.projector->forward(x, sx);
  watch(iterations, x, sx);
  return iterations;
}

int solveMlem(const LeastSquares& problem, int iterations, Vector& unknowns,
              const SolverWatch& watch) {
  Vector inverseColumns = columnSums(problem);
  invert(inverseColumns);
  Vector sx(4 * problem.rows()), ratio(sx.size()), update(unknowns.size());
  // The mean radiance over the mean length of rays.
  problem.projector->forward(constantVector(problem.unknowns(), 1), sx);
  const double length = sumElements(sx.size(), [&](std::size_t i) { return sx[i]; });
  const double light = sumElements(sx.size(), [&](std::size_t i) {
    return static_cast<double>(std::max(problem.measured[i], 0.0F));
  });
  const auto start = static_cast<float>(length > 0 ? light / length : 0);
  for (std::size_t i = 0; i < unknowns.size(); ++i)
    unknowns[i] = i % 4 == 3 ? 0 : std::max(unknowns[i], 0.01F * start);
  if (std::ranges::max(unknowns) <= 0.011F * start)
    unknowns = constantVector(problem.unknowns(), start);
  const float least = 1e-7F * std::max(start, 1e-30F);
  problem.projector->forward(unknowns, sx);
  for (int k = 1; k <= iterations; ++k) {
    forElements(sx.size(), [&](std::size_t i) {
      ratio[i] = problem.squaredWeight[i / 4] * std::max(problem.measured[i], 0.0F) /
                 std::max(sx[i], least);
    });
    problem.projector->adjoint(ratio, update);
    forElements(unknowns.size(),
                [&](std::size_t i) { unknowns[i] *= update[i] * inverseColumns[i]; });
    problem.projector->forward(unknowns, sx);
    if (!watch(k, unknowns, sx))
      return k;
  }
  return iterations;
}

int solveSirt(const LeastSquares& problem, bool nonNegative, int iterations, Vector& unknowns,
              const SolverWatch& watch) {
  Vector inverseRows(4 * problem.rows());
  problem.projector->forward(constantVector(problem.unknowns(), 1), inverseRows);
  invert(inverseRows);
  Vector inverseColumns = columnSums(problem);
  invert(inverseColumns);
  Vector sx(4 * problem.rows()), residual(sx.size()), update(unknowns.size());
  problem.projector->forward(unknowns, sx);
  for (int k = 1; k <= iterations; ++k) {
    forElements(sx.size(), [&](std::size_t i) {
      residual[i] = inverseRows[i] * problem.squaredWeight[i / 4] * (problem.measured[i] - sx[i]);
    });
    problem.projector->adjoint(residual, update);
    forElements(unknowns.size(), [&](std::size_t i) {
      const float a = unknowns[i] + inverseColumns[i] * update[i];
      unknowns[i] = nonNegative ? std::max(a, 0.0F) : a;
    });
    problem.projector->forward(unknowns, sx);
    if (!watch(k, unknowns, sx))
      return k;
  }
  return iterations;
}

int solveCgls(const LeastSquares& problem, bool nonNegative, int iterations, Vector& unknowns,
              const SolverWatch& watch) {
  Vector sx(4 * problem.rows()), sp(sx.size()), s(unknowns.size());
  problem.projector->forward(unknowns, sx);
  problem.gradient(sx, s);
  forElements(s.size(), [&](std::size_t i) { s[i] = -s[i]; });
  Vector p = s;
  std::array<double, 3> gamma = channelNorms(s);
  auto finish = [&](int k) {
    if (nonNegative)
      for (float& a : unknowns) a = std::max(a, 0.0F);
    return k;
  };
  for (int k = 1; k <= iterations; ++k) {
    problem.projector->forward(p, sp);
    std::array<float, 4> alpha{}, beta{};
    for (std::size_t c = 0; c < 3; ++c) {
      const double energy = sumElements(problem.rows(), [&](std::size_t i) {
        const double value = sp[4 * i + c];
        return problem.squaredWeight[i] * value * value;
      });
      alpha[c] = static_cast<float>(energy > 0 ? gamma[c] / energy : 0);
    }
    forElements(p.size(), [&](std::size_t i) { unknowns[i] += alpha[i % 4] * p[i]; });
    forElements(sp.size(), [&](std::size_t i) { sx[i] += alpha[i % 4] * sp[i]; });
    if (!watch(k, unknowns, sx))
      return finish(k);
    problem.gradient(sx, s);
    const auto next = channelNorms(s);
    for (std::size_t c = 0; c < 3; ++c)
      beta[c] = static_cast<float>(gamma[c] > 0 ? next[c] / gamma[c] : 0);
    gamma = next;
    forElements(p.size(), [&](std::size_t i) { p[i] = beta[i % 4] * p[i] - s[i]; });
  }
  return finish(iterations);
}

}  // namespace volute
