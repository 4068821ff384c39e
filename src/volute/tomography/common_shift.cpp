// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/common_shift.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace volute {
namespace {

constexpr int kIterations = 60;
constexpr double kHalf = 0.5;  // [pixels]

/// The camera with its principal point moved to the right and down.
Result<Camera> moved(const Camera& camera, double pixels) {
  Mat3 k = camera.intrinsics();
  k(0, 2) += pixels, k(1, 2) += pixels;
  return Camera::calibrated({camera.width(), camera.height(), k, camera.rotation(),
                             -(camera.rotation() * camera.eye()), camera.distortion(), 0.5});
}

/// Squared relative L2, the mean over the views.
Result<double> squaredResidual(std::span<const TomographyView> views,
                               const VolumeGeometry& geometry, const TomographyOptions& options,
                               std::span<const float> start, double pixels, Progress& progress) {
  std::vector<TomographyView> at(views.begin(), views.end());
  for (TomographyView& view : at) {
    VOLUTE_ASSIGN(view.camera, moved(view.camera, pixels));
  }
  VOLUTE_ASSIGN(const Reconstruction fit, reconstruct(at, geometry, options, start, progress));
  double sum = 0;
  for (const double residual : fit.residual) sum += residual * residual;
  return sum / static_cast<double>(fit.residual.size());
}

}  // namespace

Result<std::optional<CommonShift>> findCommonShift(std::span<const TomographyView> views,
                                                   const VolumeGeometry& geometry,
                                                   const TomographyOptions& options,
                                                   const Reconstruction& reconstruction,
                                                   Progress& progress) {
  for (const TomographyView& view : views) {
    if (view.camera.isOrthographic())
      return std::nullopt;
  }
  TomographyOptions plain = options;
  plain.solver = TomographySolver::kApg;
  plain.regularization = Regularization::kNone;
  plain.lambda.reset();
  plain.iterations = kIterations;
  plain.coarseToFine = false;
  std::array<double, 3> squared{};
  for (int i = 0; i < 3; ++i) {
    VOLUTE_ASSIGN(squared[i], squaredResidual(views, geometry, plain, reconstruction.volume,
                                              (i - 1) * kHalf, progress));
  }
  const double curvature = squared[0] + squared[2] - 2 * squared[1];
  if (!(curvature > 0))
    return std::nullopt;
  CommonShift shift;
  shift.pixels = kHalf * (squared[0] - squared[2]) / (2 * curvature);
  shift.residual = std::sqrt(squared[1]);
  shift.nearest = std::sqrt(std::min(squared[0], squared[2]));
  return shift;
}

}  // namespace volute
