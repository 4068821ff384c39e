// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/optics/visibility.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "volute/base/number_word.hpp"

namespace volute {
namespace {

constexpr std::string_view kReflecting =
    "light-reflecting signs: FDS User Guide, visibility, after Mulholland (SFPE Handbook); Jin's "
    "experiments give 2 to 4";
constexpr std::string_view kEmitting =
    "light-emitting signs: FDS User Guide, visibility, after Mulholland (SFPE Handbook); Jin's "
    "experiments give 5 to 10";

}  // namespace

std::span<const SightLimit> sightLimits() {
  static const std::array<SightLimit, 4> limits{
      {{"aset-rset-maps", std::numbers::ln10 / 0.23, "reciprocal-od",
        "K < 0.23 1/m: Schroeder, Arnold, Seyfried, A Map Representation of the ASET-RSET Concept, "
        "2020, and its program",
        true},
       {"large-room", 10, "jin-reflecting", "10 m in large rooms: Purser, PD 7974-6, CIBSE Guide E",
        false},
       {"small-room", 5, "jin-reflecting", "5 m in small rooms: Purser, PD 7974-6, CIBSE Guide E",
        false},
       {"nfpa-130", 10, "jin-reflecting", "doors and walls at 10 m: NFPA 130, stations", false}}};
  return limits;
}

Result<SightLimit> sightLimit(std::string_view name) {
  std::string names;
  for (const SightLimit& limit : sightLimits()) {
    if (limit.name == name)
      return limit;
    names += fmt::format("{}{}", names.empty() ? "" : ", ", limit.name);
  }
  return fail(ErrorCode::kInvalidArgument, "sight limit '{}': expected {}", name, names);
}

std::span<const VisibilityLaw> visibilityLaws() {
  static const std::array<VisibilityLaw, 3> laws{
      {{"jin-reflecting", 3, kReflecting},
       {"jin-emitting", 8, kEmitting},
       {"reciprocal-od", std::numbers::ln10, "S = 1/D: Staubli et al. 2005, section 3"}}};
  return laws;
}

Result<VisibilityLaw> visibilityLaw(std::string_view nameOrC) {
  std::string names;
  for (const VisibilityLaw& law : visibilityLaws()) {
    if (law.name == nameOrC)
      return law;
    names += law.name + ", ";
  }
  double c = 0;
  if (readNumber(nameOrC, c) && c > 0 && std::isfinite(c))
    return VisibilityLaw{"custom", c};
  return fail(ErrorCode::kInvalidArgument,
              "visibility law '{}': expected {}or a number C > 0 (S = C / K)", nameOrC, names);
}

double visibilityDistance(double extinction, const VisibilityLaw& law) {
  return extinction > 0 ? law.c / extinction : std::numeric_limits<double>::infinity();
}

std::string_view nameOf(PictureMode mode) {
  return mode == PictureMode::kPhotometric ? "photometric" : "threshold";
}

Result<PictureMode> pictureMode(std::string_view name) {
  for (const PictureMode mode : {PictureMode::kPhotometric, PictureMode::kThreshold}) {
    if (nameOf(mode) == name)
      return mode;
  }
  return fail(
      ErrorCode::kInvalidArgument,
      "picture mode '{}': expected photometric (the light that passes) or threshold (10 % at "
      "the visibility distance)",
      name);
}

double PictureLaw::factor() const {
  return mode == PictureMode::kPhotometric ? 1 : std::numbers::ln10 / c;
}

double photometricTransmittance(double depth) {
  return std::exp(-depth);
}

double thresholdTransmittance(double depth, double c) {
  return std::exp(-depth * (std::numbers::ln10 / c));
}

double seenTransmittance(double depth, PictureMode mode, double c) {
  return mode == PictureMode::kPhotometric ? photometricTransmittance(depth)
                                           : thresholdTransmittance(depth, c);
}

std::string limitRemark(const std::string& name, double extinction) {
  const auto limit = sightLimit(name).value_or(SightLimit{});
  return fmt::format("sight limit {}: K = {:.4g} 1/m where one stands ({}{})", name, extinction,
                     limit.source,
                     limit.checked ? ""
                                   : "; this source was not checked: look it up before you rely on "
                                     "it");
}

std::vector<std::string_view> sightLimitNames() {
  std::vector<std::string_view> names;
  for (const SightLimit& limit : sightLimits()) names.push_back(limit.name);
  return names;
}

}  // namespace volute
