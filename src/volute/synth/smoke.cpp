// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <array>
#include <cmath>

#include "volute/base/parallel.hpp"
#include "volute/synth/noise.hpp"
#include "volute/synth/simulation.hpp"

namespace volute {
namespace {

constexpr float kSmokeStep = kFrameSeconds;
constexpr int kSmokeWarmUpFrames = 150;

constexpr float kSmokeBuoyancy = 0.80f;  // [m/s^2] at density 1
constexpr float kJet = 1.6f;             // [m/s^2] in the nozzles
constexpr float kDissipation = 0.22f;    // [1/s]
constexpr float kThinning = 5;           // [1/s], more of it at the open faces
constexpr float kSmokeConfinement = 0.5f;
constexpr float kStir = 1.4f;  // [m/s^2], eddies of the noise in the smoke
constexpr float kSmokeVisible = 0.03f;
constexpr float kExtinction = 4.0f;  // [1/m] at density 1

// A soft ball that blows one colour of smoke.
struct Nozzle {
  std::array<float, 3> position;   // [m], from the middle of the floor
  std::array<float, 3> direction;  // unit length, nearly
  std::array<float, 3> colour;
};

constexpr float kNozzleRadius = 0.16f;
constexpr std::array<Nozzle, 3> kNozzles = {{
    {{-0.38f, -0.22f, 0.22f}, {0.72f, -0.22f, 0.60f}, {1.00f, 0.16f, 0.14f}},
    {{0.38f, -0.22f, 0.22f}, {-0.17f, 0.75f, 0.60f}, {0.08f, 0.38f, 1.00f}},
    {{0.00f, 0.44f, 0.22f}, {-0.55f, -0.53f, 0.60f}, {1.00f, 0.70f, 0.26f}},
}};

class Smoke final : public Simulation {
 public:
  Smoke(int size, std::uint32_t seed)
      : fluid_(size, kExtent, static_cast<int>(kNozzles.size())),
        stir_(mix(seed), kExtent, 0.22f, 0.8f),
        flow_(mix(seed + 1), kExtent, 0.15f, 0.5f) {}

  int warmUpFrames() const override { return kSmokeWarmUpFrames; }

  void advanceFrame() override;
  void write(int channels, std::span<float> values) const override;

 private:
  void act(int i, int j, int k);

  Fluid fluid_;  // scalars: one density for each nozzle
  VectorNoise stir_, flow_;
  double time_ = 0;
};

void Smoke::advanceFrame() {
  time_ += kSmokeStep;
  stir_.setTime(time_);
  flow_.setTime(time_);
  fluid_.advect(kSmokeStep);
  const int n = fluid_.size();
  parallelRanges(n, 4, [&](std::size_t begin, std::size_t end) {
    for (int k = static_cast<int>(begin); k < static_cast<int>(end); ++k) {
      for (int j = 0; j < n; ++j) {
        for (int i = 0; i < n; ++i) act(i, j, k);
      }
    }
  });
  fluid_.addForces(kSmokeStep, kSmokeConfinement);
  fluid_.project();
}

// The nozzles, dissipation and the forces in one cell.
void Smoke::act(int i, int j, int k) {
  const float h = fluid_.cellSize();
  const std::array<float, 3> p = {(static_cast<float>(i) + 0.5f) * h,
                                  (static_cast<float>(j) + 0.5f) * h,
                                  (static_cast<float>(k) + 0.5f) * h};
  const std::array<float, 3> world = {p[0] - kExtent / 2, p[1] - kExtent / 2, p[2]};
  const float border = 1 - fadeAtBorder(world[0], world[1], world[2], 0.45f);
  const float keep = 1 / (1 + kSmokeStep * (kDissipation + kThinning * border));
  auto& force = fluid_.force();
  float density = 0;
  for (std::size_t s = 0; s < kNozzles.size(); ++s) {
    const Nozzle& nozzle = kNozzles[s];
    float& own = fluid_.scalars()[s].at(i, j, k);
    float distance = 0;
    for (int c = 0; c < 3; ++c) {
      distance += (world[c] - nozzle.position[c]) * (world[c] - nozzle.position[c]);
    }
    const float inside = 1 - smoothStep(0.4f * kNozzleRadius, kNozzleRadius, std::sqrt(distance));
    if (inside > 0) {
      const float flow = flow_.at(p[0], p[1], p[2])[s];
      own = std::max(own, inside * (0.75f + 0.25f * flow));
      for (int c = 0; c < 3; ++c) {
        force[c].at(i, j, k) += inside * (1 + 0.6f * flow) * kJet * nozzle.direction[c];
      }
    }
    own *= keep;
    if (own < 1e-4f)
      own = 0;
    density += own;
  }
  if (density == 0)
    return;
  const auto stir = stir_.at(p[0], p[1], p[2]);
  const float share = std::min(1.0f, 2 * density);
  for (int c = 0; c < 3; ++c) force[c].at(i, j, k) += share * kStir * stir[c];
  force[2].at(i, j, k) += kSmokeBuoyancy * std::min(1.0f, density);
}

void Smoke::write(int channels, std::span<float> values) const {
  const auto& scalars = fluid_.scalars();
  for (std::size_t i = 0; i < scalars[0].values.size(); ++i) {
    std::array<float, 3> rgb{};
    float total = 0;
    for (std::size_t s = 0; s < kNozzles.size(); ++s) {
      const float density = scalars[s].values[i];
      total += density;
      for (int c = 0; c < 3; ++c) rgb[c] += density * kNozzles[s].colour[c];
    }
    // Thin smoke is cut to exactly nothing, softly.
    const float scale = kExtinction * smoothStep(kSmokeVisible, 3 * kSmokeVisible, total);
    if (channels == 1) {
      values[i] = scale * total;
    } else {
      for (int c = 0; c < 3; ++c) values[3 * i + c] = scale * rgb[c];
    }
  }
}

}  // namespace

std::unique_ptr<Simulation> makeSmoke(int size, std::uint32_t seed) {
  return std::make_unique<Smoke>(size, seed);
}

}  // namespace volute
