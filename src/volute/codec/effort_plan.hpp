// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "volute/codec/block_encoder.hpp"
#include "volute/codec/effort.hpp"

namespace volute {

/// Which searches compress() makes at an effort.
struct EffortPlan {
  enum class Modes {
    kFew,    ///< with one wavelet, and all or no time levels
    kUsual,  ///< with two of them
    kAll,    ///< all, from some that differ much to what is beside the best of them
  };
  Modes modes = Modes::kAll;
  int coded = 0;            ///< of the modes that seem cheapest, as ModeChoice has it
  bool again = false;       ///< modes are chosen anew where the step is another than they were for
  int oneOf = 4;            ///< of so many blocks one tells what all are like, where there are many
  double nearness = 0.985;  ///< an error of that part of the one asked for is near enough
};

/// @param many  whether there are so many blocks that some tell what all are like
constexpr EffortPlan planOf(int effort, bool many = false) {
  using enum EffortPlan::Modes;
  constexpr std::array<EffortPlan, kMaxEffort> kPlans{{
      {kFew, 0, false, 32, 0.94},
      {kFew, 0, false, 16, 0.97},
      {kUsual, 0, false, 16, 0.98},
      {kAll, 0, false, 16, 0.985},
      {kAll, 3, false, 4, 0.99},
      {kAll, 3, true, 2, 0.99},
      {kAll, 6, true, 1, 0.99},
      {kAll, ModeChoice::kAll, true, 1, 0.99},
      {kAll, ModeChoice::kAll, true, 1, 0.995},
  }};
  EffortPlan plan = kPlans[static_cast<std::size_t>(std::clamp(effort, 1, kMaxEffort) - 1)];
  if (many && plan.coded <= 3)
    plan.coded = 0;
  if (many && effort <= kDefaultEffort) {
    plan.oneOf = std::max(plan.oneOf, 16);
    plan.nearness = std::min(plan.nearness, 0.985);
  }
  return plan;
}

}  // namespace volute
