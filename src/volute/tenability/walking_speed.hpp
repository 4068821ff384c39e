// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>
#include <string_view>

#include "volute/base/result.hpp"

namespace volute {

/// Laws of walking speed in smoke.
enum class SpeedLaw { kNone, kFridolf, kFrantzichNilsson };

struct SpeedLawInfo {
  SpeedLaw law;
  std::string_view name;
  std::string_view source;
  bool checked = false;  ///< checked against the source
};

std::span<const SpeedLawInfo> speedLaws();

/// "none", "fridolf" or "frantzich-nilsson".
[[nodiscard]] Result<SpeedLaw> speedLaw(std::string_view name);

/// Walking speed [m/s] in smoke of extinction K [1/m], given the speed `clear` [m/s] without smoke.
/// Fridolf et al. 2019: minus 0.34 m/s per metre of visibility (3 / K) below 3 m, at least 0.2 m/s.
/// Frantzich and Nilsson, as in FDS+Evac: times 1 - 0.057 K / 0.706, at least a tenth.
double walkingSpeed(SpeedLaw law, double clear, double extinction);

}  // namespace volute
