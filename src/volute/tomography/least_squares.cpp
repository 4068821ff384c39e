// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/least_squares.hpp"

#include <cmath>

#include "volute/tomography/vector_ops.hpp"

namespace volute {

void LeastSquares::gradient(std::span<const float> projected, std::span<float> gradient) const {
  std::vector<float> residual(projected.size());
  forElements(residual.size(), [&](std::size_t i) {
    residual[i] = squaredWeight[i / 4] * misfit(i, &projected[i - i % 4]);
  });
  projector->adjoint(residual, gradient);
}

void LeastSquares::projectAndGradient(std::span<const float> a, std::span<float> projected,
                                      std::span<float> gradient) const {
  projector->thereAndBack(
      a,
      [this](std::size_t row, const float* sum, float* back) {
        for (std::size_t c = 0; c < 4; ++c) back[c] = squaredWeight[row] * misfit(4 * row + c, sum);
      },
      projected, gradient);
}

double LeastSquares::squaredResidual(std::span<const float> projected) const {
  return sumElements(projected.size(), [&](std::size_t i) {
    const double r = misfit(i, &projected[i - i % 4]);
    return squaredWeight[i / 4] * r * r;
  });
}

std::vector<float> LeastSquares::majorizer() const {
  std::vector<float> x(4 * unknowns()), sx(4 * rows()), out(unknowns());
  for (std::size_t i = 0; i < x.size(); i += 4) x[i] = 1;
  projector->forward(x, sx);
  forElements(sx.size(), [&](std::size_t i) { sx[i] *= squaredWeight[i / 4]; });
  projector->adjoint(sx, x);
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = x[4 * i];
  return out;
}

double LeastSquares::largestEigenvalue() const {
  constexpr int kIterations = 12;
  // All weights are positive, so that the eigenvector is: a constant is near to it.
  std::vector<float> x(4 * unknowns()), sx(4 * rows());
  for (std::size_t i = 0; i < x.size(); i += 4) x[i] = 1;
  double eigenvalue = 0;
  for (int k = 0; k < kIterations; ++k) {
    projector->forward(x, sx);
    forElements(sx.size(), [&](std::size_t i) { sx[i] *= squaredWeight[i / 4]; });
    projector->adjoint(sx, x);
    eigenvalue = std::sqrt(dot(x, x));
    if (eigenvalue == 0)
      return 0;
    const auto scale = static_cast<float>(1 / eigenvalue);
    forElements(x.size(), [&](std::size_t i) { x[i] *= scale; });
  }
  return eigenvalue;
}

}  // namespace volute
