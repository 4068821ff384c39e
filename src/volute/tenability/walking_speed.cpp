// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tenability/walking_speed.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "volute/base/number_word.hpp"

namespace volute {

std::span<const SpeedLawInfo> speedLaws() {
  using Kind = SpeedLaw::Kind;
  static constexpr std::array<SpeedLawInfo, 3> laws{{
      {{Kind::kNone, {}}, "none", {}, "smoke does not slow people down", true},
      {{Kind::kFridolf, {0.34, 3, 0.2}},
       "fridolf",
       {"slope [m/s per m of visibility]", "below a visibility of [m]", "at least [m/s]"},
       "Fridolf, Nilsson, Frantzich, Ronchi, Arias: The representation of evacuation movement in "
       "smoke-filled underground transportation systems, 2019; as public programs quote it"},
      {{Kind::kFrantzichNilsson, {0.706, -0.057, 0.1}},
       "frantzich-nilsson",
       {"alpha [m/s]", "beta [m2/s]", "at least, of the speed in clear air"},
       "FDS+Evac Guide, eq. 11 (alpha 0.706, beta -0.057, a tenth at least), after Frantzich and "
       "Nilsson, as pyFDS-Evac quotes it"},
  }};
  return laws;
}

const SpeedLawInfo& infoOf(const SpeedLaw& law) {
  return speedLaws()[static_cast<std::size_t>(law.kind)];
}

bool isOwn(const SpeedLaw& law) {
  return law.coefficients != infoOf(law).law.coefficients;
}

Result<SpeedLaw> speedLaw(std::string_view text) {
  const std::size_t colon = text.find(':');
  const std::string_view name = text.substr(0, colon);
  const auto* found = std::ranges::find(speedLaws(), name, &SpeedLawInfo::name).base();
  if (found == speedLaws().data() + speedLaws().size()) {
    return fail(ErrorCode::kInvalidArgument,
                "walking speed '{}': expected none, fridolf or frantzich-nilsson", name);
  }
  SpeedLaw law = found->law;
  if (colon == text.npos)
    return law;
  const auto wrong = [&] {
    return fail(ErrorCode::kInvalidArgument,
                "walking speed '{}': expected three coefficients behind the colon: {}; published "
                "are {:g},{:g},{:g}",
                text, fmt::join(found->coefficients, ", "), found->law.coefficients[0],
                found->law.coefficients[1], found->law.coefficients[2]);
  };
  if (law.isNone())
    return fail(ErrorCode::kInvalidArgument, "walking speed '{}': none has no coefficients", text);
  std::string_view rest = text.substr(colon + 1);
  for (std::size_t i = 0; i < law.coefficients.size(); ++i) {
    const std::size_t comma = rest.find(',');
    const bool last = i + 1 == law.coefficients.size();
    if (last != (comma == rest.npos) || !readNumber(rest.substr(0, comma), law.coefficients[i]))
      return wrong();
    rest = last ? std::string_view() : rest.substr(comma + 1);
  }
  const auto& [a, b, least] = law.coefficients;
  const bool sensible = law.kind == SpeedLaw::Kind::kFridolf
                            ? a >= 0 && b > 0 && least > 0
                            : a > 0 && b <= 0 && least > 0 && least <= 1;
  if (!sensible || !std::isfinite(a + b + least))
    return wrong();
  return law;
}

double walkingSpeed(const SpeedLaw& law, double clear, double extinction) {
  if (!(extinction > 0) || law.isNone())
    return clear;
  const auto& [a, b, least] = law.coefficients;
  if (law.kind == SpeedLaw::Kind::kFridolf) {
    const double sight = 3 / extinction;
    return sight >= b ? clear : std::min(clear, std::max(least, clear - a * (b - sight)));
  }
  return clear * std::clamp(1 + b * extinction / a, least, 1.0);
}

}  // namespace volute
