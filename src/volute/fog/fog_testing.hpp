// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "volute/fog/fog_medium.hpp"

// Maps, profiles and rays that the module's tests share.

namespace volute::fogtest {

inline double depthOf(const FogMedium& fog, const Segment& segment) {
  double depth = 0;
  fog.opticalDepth({&segment, 1}, {&depth, 1});
  return depth;
}

struct NamedProfile {
  std::string name;
  FogProfile profile;
};

inline std::vector<NamedProfile> profiles() {
  const FogProfile::Knot knots[] = {{0, 0.2}, {1, 1}, {4, 0.5}, {4, 0.3}, {7, 0}};
  const FogProfile::Layer layers[] = {{0, 3, 0.5}, {2, 5, 0.25}, {6, 8, 1}};
  return {{"slab", *FogProfile::slab(0, 6)},
          {"linear", *FogProfile::linear(knots)},
          {"exponential", *FogProfile::exponential(1, 2.5)},
          {"layers", *FogProfile::layers(layers)}};
}

/// Blobs and hard edges; `share` of its squares are not empty. Values 0..1 in steps of 1/255.
inline SplineGrid map(int columns, int rows, unsigned seed = 1, double share = 0.6) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  SplineGrid grid(columns, rows);
  std::vector<double> on(static_cast<std::size_t>(columns) * rows);
  for (double& value : on) value = uniform(random);
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const double wave = 0.5 + 0.5 * std::sin(0.7 * i + 0.3 * j) * std::sin(0.4 * j - 0.2 * i);
      if (on[static_cast<std::size_t>(j / 6) * columns + i / 6] < share)
        grid.at(i, j) = std::round(255 * std::min(1.0, 0.7 * wave + 0.3 * uniform(random))) / 255;
    }
  }
  return grid;
}

inline FogMedium fog(const SplineGrid& grid, const FogProfile& profile, FogOptions options,
                     double sigmaMax = 0.1, double cell = 1.3) {
  SplineGrid scaled = grid;
  for (double& value : scaled.c) value *= sigmaMax;
  const FogPlacement placement{.origin = Vec3(-3, 2, 0.5), .cell = cell};
  return *FogMedium::make(*FogMap::fromCoefficients(scaled, placement), profile, options);
}

/// From above, beside and inside; some vertical, along axes and, on request, in planes between
/// cells.
inline std::vector<Segment> rays(const FogMedium& fog, int count, unsigned seed = 3,
                                 bool inPlanes = true) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-0.2, 1.2);
  Box3 box = fog.bounds();
  box.min.z() = std::max(box.min.z(), -3.0), box.max.z() = std::min(box.max.z(), 12.0);
  const auto point = [&] {
    return Vec3(box.min +
                Vec3(uniform(random), uniform(random), uniform(random)).cwiseProduct(box.size()));
  };
  std::vector<Segment> out;
  for (int i = 0; static_cast<int>(out.size()) < count; ++i) {
    const Vec3 from = point(), to = point();
    const Vec3 direction = (to - from).normalized();
    out.push_back({from, direction, 0, (to - from).norm()});
    out.push_back({from, direction, 0, kInfinity});
    Vec3 flat = direction;
    flat.z() *= 0.02;
    out.push_back({from, flat.normalized(), 0, 2 * box.size().norm()});
    Vec3 onPlanes = from;
    for (int axis = 0; axis < 2; ++axis)
      onPlanes[axis] =
          fog.domainCorner()[axis] +
          fog.cell() * std::floor((from[axis] - fog.domainCorner()[axis]) / fog.cell());
    out.push_back(
        {i % 2 && inPlanes ? onPlanes : from, Vec3::Unit(i % 3) * (i % 4 < 2 ? 1 : -1), 0, 40});
  }
  out.resize(count);
  return out;
}

}  // namespace volute::fogtest
