// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "volute/tenability/exposure.hpp"

// Fractional effective doses (FED) and concentrations (FEC): what share of an incapacitating dose
// somebody takes in per second, or what share of an incapacitating concentration is there. Equation
// numbers 63.x are those of chapter 63 of the SFPE Handbook of Fire Protection Engineering, 5th
// edition (Purser and McAllister 2016). docs/tenability.md says which were compared with what.

namespace volute {

/// How hard somebody works: breathing V_E [l/min] and the carboxyhaemoglobin D [%] that
/// incapacitates (table under 63.18).
enum class Activity { kRest, kLight, kHeavy };

enum class Clothing { kUnclothed, kClothed };

/// The injury by radiant heat that a dose is counted towards.
enum class BurnEndpoint { kPain, kSecondDegree };

/// A way to add up what the air does.
enum class DoseLaw : unsigned char {
  /// ISO 13571:2012: (CO / 35000 + HCN^2.36 / 1.2e6) exp(CO2 / 5) per minute, gases in ppm, CO2 in
  /// %. Low oxygen is not in it. The factor of CO2 is taken at all concentrations.
  kIsoGas,
  /// 63.38: (CO by 63.18 + HCN by 63.24 + NOx / 1500 + irritants' lethal doses by 63.15)
  /// exp(CO2 / 5) (63.35) + low oxygen by 63.50, below 20 %. NOx is not taken off the HCN, which
  /// would lower the dose.
  kSfpeGas,
  /// What FDS writes as FED (User's Guide, fractional effective dose; func.f90): 2.764e-5 CO^1.036
  /// + exp(CN / 43) / 220 - 1/220 with CN = HCN - NO - NO2 + NOx / 1500 + irritants, times
  /// exp(0.1903 CO2 + 2.0004) / 7.1 where there is CO2, plus low oxygen below 20 %.
  kFdsGas,
  /// What Smokeview draws as FED: CO up to 10 %, exp(0.1930 CO2 + 2.0004) / 7.1 up to 10 % of CO2,
  /// low oxygen at all times, from at most 20 %.
  kSmokeviewGas,
  /// ISO 13571:2012, 8: T^3.61 / 4.1e8 clothed (eq. 9) or T^3.4 / 5e7 unclothed or lightly clothed
  /// (eq. 10), plus radiant q^1.56 / 6.9 (second-degree burns, eq. 7) or q^1.9 / 4.2 (pain, eq. 8)
  /// above 2.5 kW/m2, per minute.
  kIsoHeat,
  /// T^3.4 / 5e7 (63.44) plus radiant q^1.33 / 1.33 (tolerance; 63.43) above 2.5 kW/m2, per minute.
  kSfpeHeat,
  /// FEC by ISO 13571:2012, eq. 4: a sum of concentrations over those that compromise escape.
  kIsoIrritants,
  /// FIC by 63.11 with table 63.6: concentrations that impair escape.
  kSfpeIrritants,
};

struct DoseLawInfo {
  DoseLaw law;
  std::string_view name;  ///< "iso-13571"
  std::string_view kind;  ///< "fed-gas", "fed-heat", "fec"
  std::string_view source;
  std::string_view checked;  ///< what it was compared with; empty: nothing
};

std::span<const DoseLawInfo> doseLaws();
const DoseLawInfo& infoOf(DoseLaw law);

/// What the exposed are like.
struct DosePerson {
  Activity activity = Activity::kLight;
  Clothing clothing = Clothing::kUnclothed;
  BurnEndpoint burns = BurnEndpoint::kPain;
};

/// Of doses: the rate [1/s]; of irritants: the concentration's fraction. NaN when a quantity that
/// the law needs is not known; others count as in clean air where they are not.
double doseRate(DoseLaw law, const DosePerson& person, const Exposure& air);

/// True where the value is itself compared with a limit, false where it is integrated over time.
bool isInstantaneous(DoseLaw law);

/// Without these a law says nothing. Of irritants at least one must be known.
std::vector<Air> needed(DoseLaw law);
/// Quantities of the air that a law takes in besides its main one.
std::vector<Air> taken(DoseLaw law);

}  // namespace volute
