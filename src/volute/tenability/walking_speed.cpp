// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tenability/walking_speed.hpp"

#include <algorithm>
#include <array>

namespace volute {

std::span<const SpeedLawInfo> speedLaws() {
  static constexpr std::array<SpeedLawInfo, 3> laws{{
      {SpeedLaw::kNone, "none", "smoke does not slow people down", true},
      {SpeedLaw::kFridolf, "fridolf",
       "Fridolf, Nilsson, Frantzich, Ronchi, Arias: The representation of evacuation movement in "
       "smoke-filled underground transportation systems, 2019; as public programs quote it"},
      {SpeedLaw::kFrantzichNilsson, "frantzich-nilsson",
       "FDS+Evac Guide, eq. 11 (alpha 0.706, beta -0.057, a tenth at least), after Frantzich and "
       "Nilsson, as pyFDS-Evac quotes it"},
  }};
  return laws;
}

Result<SpeedLaw> speedLaw(std::string_view name) {
  for (const SpeedLawInfo& one : speedLaws()) {
    if (one.name == name)
      return one.law;
  }
  return fail(ErrorCode::kInvalidArgument,
              "walking speed '{}': expected none, fridolf or frantzich-nilsson", name);
}

double walkingSpeed(SpeedLaw law, double clear, double extinction) {
  if (!(extinction > 0) || law == SpeedLaw::kNone)
    return clear;
  if (law == SpeedLaw::kFridolf) {
    const double sight = 3 / extinction;
    return sight >= 3 ? clear : std::min(clear, std::max(0.2, clear - 0.34 * (3 - sight)));
  }
  return clear * std::clamp(1 - 0.057 * extinction / 0.706, 0.1, 1.0);
}

}  // namespace volute
