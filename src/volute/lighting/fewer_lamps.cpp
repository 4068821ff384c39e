// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/lighting/fewer_lamps.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "volute/base/parallel.hpp"

namespace volute {
namespace {

/// What a lamp sends in all directions, but for its soft edge.
double powerOf(const Lamp& lamp) {
  return lamp.intensity.sum() * 2 * std::numbers::pi * (1 - lamp.coneCosine);
}

/// Two spots as one.
Lamp together(const Lamp& a, const Lamp& b) {
  const double share = powerOf(b) / (powerOf(a) + powerOf(b));
  const auto mean = [&](const auto& ofA, const auto& ofB) -> std::decay_t<decltype(ofA)> {
    return (1 - share) * ofA + share * ofB;
  };
  Lamp one = a;
  one.position = mean(a.position, b.position);
  one.edge = mean(a.edge, b.edge);
  one.radius = std::max((a.position - one.position).norm() + a.radius,
                        (b.position - one.position).norm() + b.radius);
  const Vec3 way = mean(a.direction, b.direction);
  one.direction = way.norm() > 1e-6 ? Vec3(way.normalized()) : a.direction;
  // A cone around both.
  double rim = 0;
  for (const Lamp& lamp : {a, b}) {
    const double aside = std::acos(std::clamp(lamp.direction.dot(one.direction), -1.0, 1.0));
    rim = std::max(rim,
                   aside < 1e-6 ? std::acos(lamp.coneCosine) : aside + std::acos(lamp.coneCosine));
  }
  one.coneCosine = std::cos(std::min(rim, std::numbers::pi));
  one.intensity = ((1 - a.coneCosine) * a.intensity + (1 - b.coneCosine) * b.intensity) /
                  std::max(1 - one.coneCosine, 1e-12);
  return one;
}

/// Joins the two of least cost until there are few: each knows its nearest of those behind it.
class LampPairs {
 public:
  explicit LampPairs(std::vector<Lamp> lamps) : lamps_(std::move(lamps)), nearest_(lamps_.size()) {
    Box3 box;
    for (const Lamp& lamp : lamps_) box.extend(lamp.position);
    // Lamps that shine different ways are as far apart as the ends of all.
    turn_ = box.size().maxCoeff();
    parallelRanges(lamps_.size(), 64, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) look(i);
    });
  }

  std::vector<Lamp> few(std::size_t most) {
    for (std::size_t left = lamps_.size(); left > most; --left) join();
    std::vector<Lamp> few;
    std::ranges::copy_if(lamps_, std::back_inserter(few), isThere);
    return few;
  }

 private:
  struct Nearest {
    double cost = std::numeric_limits<double>::infinity();
    std::size_t lamp = 0;
  };

  static bool isThere(const Lamp& lamp) { return lamp.intensity.sum() > 0; }

  double cost(const Lamp& a, const Lamp& b) const {
    const double powerA = powerOf(a), powerB = powerOf(b);
    const double turned = a.coneCosine > -1 && b.coneCosine > -1
                              ? (a.direction - b.direction).norm()
                              : std::abs(a.coneCosine - b.coneCosine);
    return powerA * powerB / (powerA + powerB) *
           ((a.position - b.position).squaredNorm() + turn_ * turn_ * turned * turned);
  }

  void look(std::size_t i) {
    nearest_[i] = {};
    for (std::size_t k = i + 1; k < lamps_.size() && isThere(lamps_[i]); ++k) {
      const double c = isThere(lamps_[k]) ? cost(lamps_[i], lamps_[k]) : nearest_[i].cost;
      if (c < nearest_[i].cost)
        nearest_[i] = {c, k};
    }
  }

  void join() {
    const auto least = std::ranges::min_element(nearest_, {}, &Nearest::cost);
    const auto a = static_cast<std::size_t>(least - nearest_.begin());
    const std::size_t b = least->lamp;
    lamps_[a] = together(lamps_[a], lamps_[b]);
    lamps_[b].intensity.setZero();
    nearest_[b] = {};
    look(a);
    for (std::size_t i = 0; i < b; ++i) {
      if (i == a || !isThere(lamps_[i]))
        continue;
      if (nearest_[i].lamp == a || nearest_[i].lamp == b)
        look(i);
      else if (const double c = cost(lamps_[i], lamps_[a]); i < a && c < nearest_[i].cost)
        nearest_[i] = {c, a};
    }
  }

  std::vector<Lamp> lamps_;
  std::vector<Nearest> nearest_;
  double turn_ = 0;  ///< [m] for directions a radian apart
};

}  // namespace

std::vector<Lamp> fewerLamps(std::span<const Lamp> lamps, std::size_t most) {
  std::vector<Lamp> few, spots;
  for (const Lamp& lamp : lamps) {
    if (lamp.intensity.sum() > 0)
      (lamp.kind == Lamp::Kind::kSun ? few : spots).push_back(lamp);
  }
  if (spots.size() > most)
    spots = LampPairs(std::move(spots)).few(most);
  few.insert(few.end(), spots.begin(), spots.end());
  return few;
}

double lampsDiffer(std::span<const Lamp> lamps, std::span<const Lamp> others, const Box3& box) {
  constexpr int kAcross = 8;  // places
  double difference = 0, light = 0;
  for (int i = 0; i < kAcross * kAcross * kAcross; ++i) {
    const Vec3 place(i % kAcross, i / kAcross % kAcross, i / kAcross / kAcross);
    const Vec3 point = box.min + ((place.array() + 0.5) / kAcross * box.size().array()).matrix();
    Rgb before = Rgb::Zero(), after = Rgb::Zero();
    for (const Lamp& lamp : others) before += lamp.irradiance(point);
    for (const Lamp& lamp : lamps) after += lamp.irradiance(point);
    difference += (after - before).abs().sum();
    light += before.sum();
  }
  return light > 0 ? difference / light : 0;
}

}  // namespace volute
