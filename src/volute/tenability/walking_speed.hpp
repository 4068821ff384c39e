// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "volute/base/result.hpp"

namespace volute {

/// A law of walking speed in smoke of extinction K, with its coefficients.
struct SpeedLaw {
  enum class Kind { kNone, kFridolf, kFrantzichNilsson };

  Kind kind = Kind::kNone;
  std::array<double, 3> coefficients{};  ///< in the order of SpeedLawInfo

  bool isNone() const { return kind == Kind::kNone; }
};

struct SpeedLawInfo {
  SpeedLaw law;  ///< as published
  std::string_view name;
  std::array<std::string_view, 3> coefficients;  ///< names, with their units
  std::string_view source;
  bool checked = false;  ///< checked against the source
};

std::span<const SpeedLawInfo> speedLaws();
const SpeedLawInfo& infoOf(const SpeedLaw& law);

/// Whether its coefficients are not those that are published.
bool isOwn(const SpeedLaw& law);

/// "none", "fridolf" or "frantzich-nilsson"; the others with all three coefficients of one's own
/// behind a colon: "fridolf:0.34,3,0.2".
[[nodiscard]] Result<SpeedLaw> speedLaw(std::string_view text);

/// Walking speed [m/s] in smoke of extinction K [1/m], given the speed `clear` [m/s] without smoke.
/// Fridolf et al. 2019: minus 0.34 m/s per metre of visibility (3 / K) below 3 m, at least 0.2 m/s.
/// Frantzich and Nilsson, as in FDS+Evac: times 1 + beta K / alpha with alpha = 0.706, beta =
/// -0.057, at least a tenth.
double walkingSpeed(const SpeedLaw& law, double clear, double extinction);

}  // namespace volute
