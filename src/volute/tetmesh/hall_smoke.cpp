// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tetmesh/hall_smoke.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "volute/base/parallel.hpp"

namespace volute {
namespace {

// The hall of hallMesh() [m].
constexpr double kCeiling = 6, kWall = 20.3, kLintel = 2.6, kCurtain = 8.3, kCurtainDepth = 1.2;
const Vec3 kDoor(20, 6, kLintel);
const Vec3 kSeat(24.3, 6, 0);

/// From 0 far below x = 0 to 1 far above.
double step(double x) {
  return 1 / (1 + std::exp(-x));
}

double ramp(double time, double scale) {
  return time > 0 ? 1 - std::exp(-time / scale) : 0;
}

/// Smooth made-up turbulence of mean 0 and about unit range, carried along by a wind.
class Eddies {
 public:
  explicit Eddies(std::uint32_t seed) {
    std::mt19937 random(seed);
    const auto drawn = [&] { return random() / 2147483648.0 - 1; };
    for (Wave& wave : waves_) {
      do {
        wave.vector = Vec3(drawn(), drawn(), drawn());
      } while (wave.vector.norm() > 1 || wave.vector.norm() < 0.1);
      const double length = 1.5 * std::exp2(1.5 * (drawn() + 1) / 2);  // [m]
      wave.vector *= 2 * std::numbers::pi / length / wave.vector.norm();
      wave.phase = std::numbers::pi * drawn();
      wave.rate = 0.8 * drawn();
    }
  }

  double at(const Vec3& point, double time) const {
    double sum = 0;
    for (const Wave& wave : waves_)
      sum += std::sin(wave.vector.dot(point) + wave.phase + wave.rate * time);
    return sum / std::sqrt(waves_.size() / 2.0) / 1.5;
  }

 private:
  struct Wave {
    Vec3 vector;  // [rad/m]
    double phase = 0, rate = 0;
  };

  std::array<Wave, 14> waves_;
};

/// The state of the two rooms' layers.
struct Layers {
  explicit Layers(double time) {
    roomBottom = 1.1 + (kCeiling - 1.1) * std::exp(-std::max(time - 2, 0.0) / 22);
    roomDensity = 0.3 * ramp(time, 35);
    const double outflow = time - 22;  // since the layer came down to the lintel
    reach = 0.75 * std::max(outflow, 0.0) - 1;
    hallDepth = 0.35 + 4.3 * ramp(outflow - 5, 75);
    hallDensity = 0.08 * ramp(outflow, 50);
    jet = ramp(outflow, 6);
  }

  double roomBottom, roomDensity;      // [m], [g/m3]
  double reach;                        // of the hall's layer from the door [m]
  double hallDepth, hallDensity, jet;  // below the ceiling [m], [g/m3], 0..1
};

double inRoom(const Vec3& p, const Layers& layers, double time, double eddy) {
  const double height = p.z();
  const double width = 0.32 + 0.13 * height;
  const double sway = 0.12 * height * std::sin(0.9 * time + 0.8 * height);
  const double away = std::hypot(p.x() - kSeat.x() - sway, p.y() - kSeat.y() - 0.7 * sway);
  const double column = 0.9 * ramp(time, 5) * std::exp(-0.5 * away * away / (width * width)) *
                        (1 + 0.6 * eddy) / (1 + 0.25 * height);
  const double layer = layers.roomDensity * step((height - layers.roomBottom + 0.35 * eddy) / 0.22);
  return column + layer * (1 + 0.35 * eddy);
}

double inHall(const Vec3& p, const Layers& layers, double eddy) {
  // Out of the door's upper half, then up along the wall.
  const double lift = std::max(p.z() - 2.2, 0.0);
  const double out = kDoor.x() - p.x();
  const double across = (p.y() - kDoor.y()) / (0.9 + 0.2 * lift);
  const double bend = (out - 0.35 - 0.12 * lift) / (0.5 + 0.12 * lift);
  const double jet = 0.12 * layers.jet * layers.roomDensity / 0.3 * std::exp(-across * across) *
                     std::exp(-bend * bend) * step((p.z() - 2.0) / 0.15) * (1 + 0.7 * eddy);
  const double distance = std::hypot(out, 0.7 * (p.y() - kDoor.y()));
  const bool beyond = p.x() < kCurtain;
  const double spill = beyond ? step((layers.hallDepth - kCurtainDepth - 0.25) / 0.12) : 1;
  const double depth = layers.hallDepth * (beyond ? 0.85 : 1);
  const double bottom = kCeiling - depth + 0.3 * eddy;
  const double layer = layers.hallDensity * spill * step((p.z() - bottom) / 0.25) *
                       step((layers.reach - distance + 0.9 * eddy) / 0.8);
  return std::max(jet, 0.0) + layer * (1 + 0.45 * eddy);
}

}  // namespace

std::vector<float> hallSmoke(std::span<const Vec3> points, double time, std::uint32_t seed) {
  constexpr double kClear = 2e-4;  // [g/m3]; less is air
  const Eddies eddies(seed);
  const Layers layers(time);
  std::vector<float> soot(points.size());
  parallelRanges(soot.size(), 2048, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3& p = points[i];
      const double eddy = std::clamp(eddies.at(p, time), -1.3, 1.3);
      const double value = p.x() > kWall ? inRoom(p, layers, time, eddy) : inHall(p, layers, eddy);
      soot[i] = static_cast<float>(std::max(value - kClear, 0.0));
    }
  });
  return soot;
}

}  // namespace volute
