// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "volute/visibility/floor_plan.hpp"

namespace volute {

/// Finds where it burns from the smoke of a plan, of cases that do not say it. Where the first
/// smoke at the eyes' height is a small patch in clear air, below which it reaches down to the
/// floor, it rises from there: a column over a fire. A layer or a jet below a ceiling has little
/// smoke below it, and a filled room no clear air around. The column is followed, as it sways,
/// until the smoke around it is no longer clear.
class SmokeColumn {
 public:
  static constexpr double kSmoke = 0.1;     ///< less is clear air [1/m]
  static constexpr double kMaxArea = 20;    ///< of a patch [m2]
  static constexpr double kClear = 1. / 3;  ///< of a patch's edge, what is clear air, not walls
  static constexpr double kSway = 1;        ///< how far a column goes from its first place [m]
  static constexpr double kMargin = 0.5;    ///< around it [m]

  /// [bytes] of each eye, with what is asked of the places below.
  static constexpr std::uint64_t kBytesOfEye = 180;

  /// @param places  of the plan, and of each its eye and the floor below it; NaN: none is near
  SmokeColumn(const FloorPlan& plan, std::span<const std::size_t> places,
              std::span<const Vec3> eyes, std::span<const double> floors);

  /// The places where update() wants to know the smoke besides that at the eyes.
  const std::vector<Vec3>& below() const { return below_; }

  /// Times ascend.
  /// @param here, below  extinctions at the eyes and at below() [1/m]; NaN: not known
  void update(double time, std::span<const double> here, std::span<const double> below);

  /// Which eyes are in a column, or next to it; empty: none was found.
  std::vector<bool> eyes() const;

  /// "smoke rises from the floor around x = 24.5, y = 6.5 m, up to 1.6 m from there, at 5 s first".
  std::string words() const;

 private:
  using Patch = std::vector<std::size_t>;  // of eyes, connected

  std::vector<Patch> patches(std::span<const double> here) const;
  bool isColumn(const Patch& patch, std::span<const double> here,
                std::span<const double> below) const;

  /// The eyes on the four sides of one; -1: there is none.
  std::array<std::ptrdiff_t, 4> beside(std::size_t eye) const;

  /// Eyes that one reaches from some others within so many metres, without the walls between.
  std::vector<bool> grown(const std::vector<bool>& eyes, double metres) const;

  FloorPlan plan_;
  std::vector<std::size_t> places_;
  std::vector<Vec3> eyes_, below_;  // two below each eye that has a floor, from firstBelow_ on
  std::vector<std::ptrdiff_t> eyeAt_, firstBelow_;
  std::vector<bool> column_, reach_;  // empty: none yet
  double time_ = 0;
  bool done_ = false;
};

}  // namespace volute
