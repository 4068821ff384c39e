// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>
#include <string_view>

#include "volute/base/result.hpp"

namespace volute {

/// How smoke slows people down.
enum class SpeedLaw { kNone, kFridolf, kFrantzichNilsson };

struct SpeedLawInfo {
  SpeedLaw law;
  std::string_view name;
  std::string_view source;
  bool checked = false;  ///< the source was read, not quoted from memory
};

std::span<const SpeedLawInfo> speedLaws();

/// "none", "fridolf" or "frantzich-nilsson".
[[nodiscard]] Result<SpeedLaw> speedLaw(std::string_view name);

/// The speed [m/s] in smoke of extinction K [1/m] of somebody who walks at `clear` [m/s] without.
/// Fridolf et al. 2019: 0.34 m/s less for each metre of sight (3 / K) below 3 m, 0.2 m/s at least.
/// Frantzich and Nilsson, as FDS+Evac has it: times 1 - 0.057 K / 0.706, a tenth at least.
double walkingSpeed(SpeedLaw law, double clear, double extinction);

}  // namespace volute
