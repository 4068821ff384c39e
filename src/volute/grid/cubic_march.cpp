// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/cubic_march.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "volute/base/parallel.hpp"
#include "volute/grid/voxel_cells.hpp"
#include "volute/math/quadrature.hpp"

namespace volute {
namespace {

constexpr int kCubicNodes = 5;
constexpr double kCubicDepth = 1.2, kCubicSteps = 64;
constexpr float kCubicLightLost = 1e-6F;

/// Four floats in one register, of any CPU (an extension of GCC and Clang).
using F4 = float __attribute__((vector_size(16)));

inline F4 loadFour(const float* from) {
  F4 out;
  std::memcpy(&out, from, sizeof out);
  return out;
}

/// The B-splines at a place of a cell: along x together, and each product of those along y and z.
struct NodeShares {
  alignas(16) float x[4];
  alignas(16) float yz[16];

  void set(float px, float py, float pz) {
    float y[4], z[4];
    along(px, x), along(py, y), along(pz, z);
    for (int k = 0; k < 4; ++k) {
      for (int j = 0; j < 4; ++j) yz[4 * k + j] = z[k] * y[j];
    }
  }

  static void along(float t, float* out) {
    constexpr float kSixth = 1 / 6.0F;
    const float s = 1 - t;
    const float t2 = t * t, s2 = s * s;
    out[0] = s2 * s * kSixth;
    out[1] = (4 + t2 * (3 * t - 6)) * kSixth;
    out[2] = (4 + s2 * (3 * s - 6)) * kSixth;
    out[3] = t2 * t * kSixth;
  }

  /// The value there, of the 64 coefficients whose first is at `from`.
  float value(const float* from) const {
    F4 even{}, odd{};
    for (int k = 0; k < 4; ++k) {
      const float* plane = from + k * CubicGrid::kSide * CubicGrid::kSide;
      for (int j = 0; j < 4; j += 2) {
        const float* row = plane + j * CubicGrid::kSide;
        even += loadFour(row) * yz[4 * k + j];
        odd += loadFour(row + CubicGrid::kSide) * yz[4 * k + j + 1];
      }
    }
    const F4 sum = (even + odd) * loadFour(x);
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
  }
};

/// The five Gauss points of [0, 1], their weights, and the integrals up to each of the polynomials
/// that are 1 at one and 0 at the others.
struct GaussTable {
  float node[kCubicNodes], weight[kCubicNodes], upTo[kCubicNodes][kCubicNodes];

  GaussTable() {
    const GaussRule rule = gaussRule(kCubicNodes);
    double at[kCubicNodes];
    for (std::size_t i = 0; i < kCubicNodes; ++i) {
      at[i] = 0.5 * (1 + rule.nodes[i]);
      node[i] = static_cast<float>(at[i]);
      weight[i] = static_cast<float>(0.5 * rule.weights[i]);
    }
    for (int i = 0; i < kCubicNodes; ++i) {
      for (int j = 0; j < kCubicNodes; ++j) {
        upTo[i][j] = static_cast<float>(gaussIntegral(3, 0, at[i], [&](double u) {
          double product = 1;
          for (int k = 0; k < kCubicNodes; ++k)
            product *= k == j ? 1 : (u - at[k]) / (at[j] - at[k]);
          return product;
        }));
      }
    }
  }
};

const GaussTable& gaussTable() {
  static const GaussTable table;
  return table;
}

/// What a ray has gathered.
struct CubicRay {
  const CubicGrid& grid;
  const GaussTable& gauss = gaussTable();
  float sum[3]{};
  float passed = 1;

  /// The line integrals of the channels alone.
  void addLine(const voxels::InCell& in, const float* from, double length, int channels) {
    NodeShares shares;
    for (int i = 0; i < kCubicNodes; ++i) {
      place(in, static_cast<double>(gauss.node[i]) * length, shares);
      const float weight = gauss.weight[i] * static_cast<float>(length);
      for (int c = 0; c < channels; ++c)
        sum[c] += weight * shares.value(from + c * CubicGrid::kCoefficients);
    }
  }

  static void place(const voxels::InCell& in, double u, NodeShares& shares) {
    const Vec3 at = in.at + u * in.velocity;
    shares.set(static_cast<float>(at.x()), static_cast<float>(at.y()), static_cast<float>(at.z()));
  }

  /// Emission and extinction that have their own ways.
  void addAbsorbing(const voxels::InCell& in, const float* from, double length) {
    const double depth = step(in, from, 0, length, kCubicDepth);
    if (depth <= kCubicDepth)
      return;
    const int count = static_cast<int>(std::min(std::ceil(depth / kCubicDepth), kCubicSteps));
    for (int i = 0; i < count; ++i) step(in, from, length * i / count, length / count, 1e30);
  }

  /// Adds what is between u and u + length, unless its optical depth is more than `most`.
  /// @return  the depth
  double step(const voxels::InCell& in, const float* from, double u, double length, double most) {
    float extinction[kCubicNodes], sent[kCubicNodes][3];
    const bool own = grid.channels() == 4;
    const auto scale = static_cast<float>(own ? length : grid.extinctionScale / 3 * length);
    NodeShares shares;
    float depth = 0;
    for (int i = 0; i < kCubicNodes; ++i) {
      place(in, u + static_cast<double>(gauss.node[i]) * length, shares);
      const float* emission = own ? from + CubicGrid::kCoefficients : from;
      for (int c = 0; c < 3; ++c)
        sent[i][c] = shares.value(emission + c * CubicGrid::kCoefficients);
      extinction[i] = scale * (own ? shares.value(from) : sent[i][0] + sent[i][1] + sent[i][2]);
      depth += gauss.weight[i] * extinction[i];
    }
    if (depth > most)
      return depth;
    for (int i = 0; i < kCubicNodes; ++i) {
      float before = 0;
      for (int j = 0; j < kCubicNodes; ++j) before += gauss.upTo[i][j] * extinction[j];
      const float weight =
          passed * std::exp(-before) * gauss.weight[i] * static_cast<float>(length);
      for (int c = 0; c < 3; ++c) sum[c] += weight * sent[i][c];
    }
    passed *= std::exp(-depth);
    return depth;
  }
};

}  // namespace

Radiance marchCubic(const CubicGrid& grid, const Segment& segment) {
  CubicRay ray{.grid = grid};
  const int channels = grid.channels();
  const bool absorbing = channels == 4 || (channels == 3 && grid.extinctionScale != 0);
  const auto mostLine = static_cast<float>(channels == 1 && grid.extinctionScale > 0
                                               ? -std::log(kCubicLightLost) / grid.extinctionScale
                                               : 3e38);
  grid.traverse(segment, [&](const auto& cell, const float* from, double begin, double end) {
    const voxels::InCell in(grid.cells, cell, segment, begin, end);
    if (absorbing)
      ray.addAbsorbing(in, from, end - begin);
    else
      ray.addLine(in, from, end - begin, channels);
    return ray.passed > kCubicLightLost && ray.sum[0] < mostLine;
  });
  Radiance light;
  light.transmittance = ray.passed;
  const double scale = channels == 4 ? 1 : grid.emissionScale;
  for (int c = 0; c < 3; ++c) light.emitted[c] = scale * ray.sum[channels == 1 ? 0 : c];
  if (channels == 1 && grid.extinctionScale != 0) {
    // Emission is a multiple of extinction all along: the light depends on the depth alone.
    const double depth = grid.extinctionScale * ray.sum[0];
    light.transmittance = std::exp(-depth);
    if (depth != 0)
      light.emitted *= -std::expm1(-depth) / depth;
  }
  return light;
}

}  // namespace volute
