// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <cmath>

#include "volute/base/parallel.hpp"
#include "volute/synth/noise.hpp"
#include "volute/synth/simulation.hpp"

namespace volute {
namespace {

constexpr int kFireStepsPerFrame = 2;
constexpr float kFireStep = kFrameSeconds / kFireStepsPerFrame;
constexpr int kFireWarmUpFrames = 45;

constexpr float kBurnerRadius = 0.32f;  // [m]
constexpr float kBurnerHeight = 0.07f;
constexpr float kBurnTime = 0.25f;      // [s], in which fuel turns to heat
constexpr float kHeatOfFuel = 2.6f;     // temperatures are relative: 1 is a bright flame
constexpr float kCooling = 1.7f;        // [1/s]
constexpr float kRadiation = 2.5f;      // [1/s] at temperature 1, with its third power
constexpr float kFireBuoyancy = 10.0f;  // [m/s^2] at temperature 1
constexpr float kFireConfinement = 0.7f;
constexpr float kSwelling = 3.0f;  // volumes of hot gas more than of fuel
constexpr float kGust = 6.0f;      // [m/s^2], eddies of the large noise in the flame
constexpr float kCurl = 16.0f;     // and of the small one

constexpr float kFireVisible = 0.3f;  // temperature below which nothing glows
constexpr float kRadiance = 5.0f;     // [radiance/m] at temperature 1

class Fire final : public Simulation {
 public:
  Fire(int size, std::uint32_t seed)
      : fluid_(size, kExtent, 2),
        gusts_(mix(seed), kExtent, 0.25f, 0.35f),
        curls_(mix(seed + 1), kExtent, 0.10f, 0.12f),
        inlet_(mix(seed + 2), kExtent, 0.12f, 0.16f) {}

  int warmUpFrames() const override { return kFireWarmUpFrames; }

  void advanceFrame() override {
    for (int i = 0; i < kFireStepsPerFrame; ++i) step();
  }

  void write(int channels, std::span<float> values) const override;

 private:
  void step();
  void react(int i, int j, int k);

  Fluid fluid_;  // scalars: fuel, temperature
  VectorNoise gusts_, curls_, inlet_;
  double time_ = 0;
};

void Fire::step() {
  time_ += kFireStep;
  for (VectorNoise* noise : {&gusts_, &curls_, &inlet_}) noise->setTime(time_);
  fluid_.advect(kFireStep);
  const int n = fluid_.size();
  parallelRanges(n, 4, [&](std::size_t begin, std::size_t end) {
    for (int k = static_cast<int>(begin); k < static_cast<int>(end); ++k) {
      for (int j = 0; j < n; ++j) {
        for (int i = 0; i < n; ++i) react(i, j, k);
      }
    }
  });
  fluid_.addForces(kFireStep, kFireConfinement);
  fluid_.project();
}

// The burner, combustion, cooling and the forces in one cell.
void Fire::react(int i, int j, int k) {
  const float h = fluid_.cellSize();
  const float px = (static_cast<float>(i) + 0.5f) * h;
  const float py = (static_cast<float>(j) + 0.5f) * h;
  const float pz = (static_cast<float>(k) + 0.5f) * h;
  const float x = px - kExtent / 2;
  const float y = py - kExtent / 2;
  float& fuel = fluid_.scalars()[0].at(i, j, k);
  float& heat = fluid_.scalars()[1].at(i, j, k);
  const float radius = std::sqrt(x * x + y * y);
  if (pz < kBurnerHeight && radius < kBurnerRadius) {
    const float flow = inlet_.at(px, py, pz)[0];
    const float amount = (1 - smoothStep(0.75f * kBurnerRadius, kBurnerRadius, radius)) *
                         smoothStep(-0.5f, 0.5f, flow);
    fuel = std::max(fuel, amount);
    heat = std::max(heat, 0.2f * amount);
  }
  float& expansion = fluid_.expansion().at(i, j, k);
  expansion = 0;
  if (fuel == 0 && heat == 0)
    return;
  const float burnt = fuel * (kFireStep / (kBurnTime + kFireStep));
  fuel -= burnt;
  heat += kHeatOfFuel * burnt;
  expansion = kSwelling * burnt / kFireStep;
  heat /= 1 + kFireStep * (kCooling + kRadiation * heat * heat * heat);
  const float fade = fadeAtBorder(x, y, pz, 0.30f);
  fuel *= fade;
  heat *= fade;
  if (heat < 1e-4f)
    heat = 0;
  if (fuel < 1e-4f)
    fuel = 0;
  const auto gust = gusts_.at(px, py, pz);
  const auto curl = curls_.at(px, py, pz);
  const float share = std::min(1.0f, 2 * heat);
  for (int c = 0; c < 3; ++c)
    fluid_.force()[c].at(i, j, k) = share * (kGust * gust[c] + kCurl * curl[c]);
  fluid_.force()[2].at(i, j, k) += kFireBuoyancy * heat;
}

void Fire::write(int channels, std::span<float> values) const {
  const auto& heat = fluid_.scalars()[1].values;
  for (std::size_t i = 0; i < heat.size(); ++i) {
    const float t = std::max(0.0f, heat[i] - kFireVisible) / (1 - kFireVisible);
    // Radiance climbs steeply with temperature; the colour goes from deep red through orange to a
    // pale yellow.
    const float strength = kRadiance * t * t;
    const float red = strength;
    const float green = strength * (0.05f + 0.58f * smoothStep(0.0f, 1.4f, t));
    const float blue = strength * (0.003f + 0.16f * smoothStep(0.45f, 1.5f, t));
    if (channels == 1) {
      values[i] = 0.2126f * red + 0.7152f * green + 0.0722f * blue;
    } else {
      values[3 * i] = red;
      values[3 * i + 1] = green;
      values[3 * i + 2] = blue;
    }
  }
}

}  // namespace

std::unique_ptr<Simulation> makeFire(int size, std::uint32_t seed) {
  return std::make_unique<Fire>(size, seed);
}

}  // namespace volute
