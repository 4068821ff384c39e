// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors

// A glowing ball is photographed from eight directions and reconstructed from these pictures.

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "volute/tomography/project.hpp"
#include "volute/tomography/reconstruct.hpp"

namespace {

constexpr int kVoxels = 16;

/// Brightest in the middle; shape (z, y, x, 3), radiance per metre.
std::vector<float> ball() {
  std::vector<float> volume;
  for (int z = 0; z < kVoxels; ++z)
    for (int y = 0; y < kVoxels; ++y)
      for (int x = 0; x < kVoxels; ++x) {
        const volute::Vec3 point =
            volute::Vec3(x, y, z) / (0.5 * (kVoxels - 1)) - volute::Vec3::Ones();  // -1 .. 1
        const auto glow = static_cast<float>(std::max(0.0, 1 - point.squaredNorm() / 0.36));
        volume.insert(volume.end(), {glow, 0.6f * glow, 0.2f * glow});
      }
  return volume;
}

volute::Status reconstructTheBall() {
  const volute::VolumeGeometry geometry{{volute::Vec3::Constant(-1), volute::Vec3::Constant(1)},
                                        {kVoxels, kVoxels, kVoxels}};
  const std::vector<float> truth = ball();

  volute::TomographyOptions options;
  options.raysPerPixel = 1;
  options.iterations = 60;
  options.regularization = volute::Regularization::kSmooth;

  std::vector<volute::TomographyView> views;
  for (int i = 0; i < 8; ++i) {
    const double angle = std::numbers::pi * i / 8;
    volute::View3 from;
    from.eye = 5 * volute::Vec3(std::cos(angle), std::sin(angle), 0.2);
    const auto camera = volute::Camera::pinhole(from, 30, 32, 32);
    views.push_back({.name = fmt::format("camera {}", i),
                     .camera = camera,
                     .radiance = volute::projectVolume(truth, geometry, options.basis, camera,
                                                       options.raysPerPixel)});
  }

  volute::Progress quiet;
  VOLUTE_ASSIGN(const auto found, volute::reconstruct(views, geometry, options, {}, quiet));

  double off = 0, all = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    off += std::pow(found.volume[i] - truth[i], 2);
    all += std::pow(truth[i], 2);
  }
  const double error = std::sqrt(off / all);
  fmt::print("{} iterations, {:.1f} % of the voxels in the hull, relative error {:.3f}\n",
             found.iterations, 100 * found.hullShare, error);
  if (error > 0.1)
    return volute::fail(volute::ErrorCode::kInvalidData, "that is not the ball");
  return {};
}

}  // namespace

int main() {
  if (const auto done = reconstructTheBall(); !done) {
    fmt::print(stderr, "{}\n", done.error().message);
    return 1;
  }
}
