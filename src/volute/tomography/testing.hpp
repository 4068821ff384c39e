// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "volute/tomography/project.hpp"

namespace volute {

/// A made-up flame of a few blobs in the cube from -1 to 1, and cameras around it. Its pictures are
/// integrals through twice the resolution and the other basis than what is reconstructed.
struct TestScene {
  static constexpr int kSide = 20;
  VolumeGeometry geometry{{Vec3(-1, -1, -1), Vec3(1, 1, 1)}, {kSide, kSide, kSide}};
  std::vector<float> truth;  ///< at the resolution of `geometry`
  std::vector<TomographyView> views;

  /// @param phase  moves the blobs: another instant.
  /// @param pictureWidth, pictureHeight  [pixels]; what they show of the scene depends on their
  /// shape alone.
  explicit TestScene(int cameras, double noise = 0, double phase = 0, int pictureWidth = 48,
                     int pictureHeight = 44) {
    const VolumeGeometry fine{geometry.bounds, {2 * kSide, 2 * kSide, 2 * kSide}};
    const std::vector<float> volume = blobs(fine, phase);
    truth = blobs(geometry, phase);
    std::mt19937 random(11);
    std::normal_distribution<float> normal;
    for (int i = 0; i < cameras; ++i) {
      const double angle = 2 * std::numbers::pi * (i + 0.2) / cameras;
      const double height = i % 2 == 0 ? -0.6 : 0.9;
      const Vec3 eye(5 * std::cos(angle), 5 * std::sin(angle), height);
      const Camera camera = Camera::pinhole({eye, Vec3::Zero()}, 30, pictureWidth, pictureHeight);
      Image image = projectVolume(volume, fine, Basis::kBox, camera, 4);
      for (float& value : image.pixels) value += static_cast<float>(noise) * normal(random);
      views.push_back({fmt::format("c{}", i), camera, std::move(image)});
    }
  }

  /// Relative L2 of a volume.
  double error(std::span<const float> volume) const {
    double difference = 0, size = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      difference += std::pow(static_cast<double>(volume[i]) - truth[i], 2);
      size += std::pow(truth[i], 2);
    }
    return std::sqrt(difference / size);
  }

  static std::vector<float> blobs(const VolumeGeometry& geometry, double phase) {
    struct Blob {
      Vec3 centre;
      double radius;
      Rgb colour;
    };

    const std::vector<Blob> all{{Vec3(0.1 + 0.3 * phase, 0, -0.35), 0.5, Rgb(2, 1.0, 0.3)},
                                {Vec3(-0.2, 0.25 - 0.2 * phase, 0.1), 0.45, Rgb(1.5, 0.6, 0.1)},
                                {Vec3(0.2, -0.15 + 0.3 * phase, 0.45), 0.4, Rgb(1, 0.3, 0.0)}};
    std::vector<float> values;
    const auto& n = geometry.resolution;
    for (int z = 0; z < n[2]; ++z)
      for (int y = 0; y < n[1]; ++y)
        for (int x = 0; x < n[0]; ++x) {
          const Vec3 point = geometry.bounds.min +
                             Vec3(x + 0.5, y + 0.5, z + 0.5).cwiseProduct(geometry.voxelSize());
          Rgb sum = Rgb::Zero();
          for (const Blob& blob : all) {
            const double r = (point - blob.centre).norm() / blob.radius;
            sum += blob.colour * std::max(0.0, 1 - r * r);
          }
          for (int c = 0; c < 3; ++c) values.push_back(static_cast<float>(sum[c]));
        }
    return values;
  }
};

}  // namespace volute
