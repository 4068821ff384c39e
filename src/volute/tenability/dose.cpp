// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tenability/dose.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace volute {
namespace {

constexpr double kMinute = 60;  // [s]

/// Irritants: the concentrations F of ISO 13571:2012 (6.2.1) and those that impair escape by table
/// 63.6 [ppm], and lethal doses by table 63.7 [ppm min].
struct Irritant {
  Air gas;
  double iso, escape, lethal;
};

constexpr std::array<Irritant, 7> kIrritants{{
    {Air::kHydrogenChloride, 1000, 200, 114000},
    {Air::kHydrogenBromide, 1000, 200, 114000},
    {Air::kHydrogenFluoride, 500, 200, 87000},
    {Air::kSulfurDioxide, 150, 24, 12000},
    {Air::kNitrogenDioxide, 250, 70, 1900},
    {Air::kAcrolein, 30, 4, 4500},
    {Air::kFormaldehyde, 250, 6, 22500},
}};

/// As in clean air where it is not known; never negative, as interpolated values can be.
Exposure completed(Exposure air) {
  for (const AirQuantity& one : airQuantities()) {
    double& value = air[one.quantity];
    if (std::isnan(value))
      value = one.clean;
    if (one.quantity != Air::kTemperature)
      value = std::max(value, 0.0);
  }
  return air;
}

double sumOver(const Exposure& air, double Irritant::* concentration) {
  double sum = 0;
  for (const Irritant& irritant : kIrritants)
    sum += air.ppm(irritant.gas) / irritant.*concentration;
  return sum;
}

/// Stewart's equation, 63.18: 3.317e-5 CO^1.036 V_E / D [1/min].
double stewart(double ppm, Activity activity) {
  const double breathing =
      activity == Activity::kRest ? 8.5 : (activity == Activity::kLight ? 25 : 50);
  const double blood = activity == Activity::kRest ? 40 : (activity == Activity::kLight ? 30 : 20);
  return 3.317e-5 * std::pow(ppm, 1.036) * breathing / blood;
}

/// 63.50 [1/min].
double lowOxygen(double percent) {
  return std::exp(0.54 * (20.9 - percent) - 8.13);
}

double nitrogenOxides(const Exposure& air) {
  return (air.ppm(Air::kNitricOxide) + air.ppm(Air::kNitrogenDioxide)) / 1500;
}

double isoGas(const Exposure& air) {
  const double gases = air.ppm(Air::kCarbonMonoxide) / 35000 +
                       std::pow(air.ppm(Air::kHydrogenCyanide), 2.36) / 1.2e6;
  return gases * std::exp(air.percent(Air::kCarbonDioxide) / 5);
}

double sfpeGas(const Exposure& air, Activity activity) {
  const double gases = stewart(air.ppm(Air::kCarbonMonoxide), activity) +
                       std::pow(air.ppm(Air::kHydrogenCyanide), 2.36) / 1.2e6 +
                       nitrogenOxides(air) + sumOver(air, &Irritant::lethal);
  const double oxygen = air.percent(Air::kOxygen);
  return gases * std::exp(air.percent(Air::kCarbonDioxide) / 5) +
         (oxygen < 20 ? lowOxygen(oxygen) : 0);
}

/// The coefficients of func.f90 are those of 63.18 rounded to four digits.
double fdsCarbonMonoxide(double ppm, Activity activity) {
  const double factor = activity == Activity::kRest
                            ? 0.7048625e-5
                            : (activity == Activity::kLight ? 2.764e-5 : 8.2925e-5);
  return factor * std::pow(ppm, 1.036);
}

double fdsGas(const Exposure& air, Activity activity) {
  const double cyanide = std::max(0.0, air.ppm(Air::kHydrogenCyanide) - air.ppm(Air::kNitricOxide) -
                                           air.ppm(Air::kNitrogenDioxide));
  const double gases = fdsCarbonMonoxide(air.ppm(Air::kCarbonMonoxide), activity) +
                       std::expm1(cyanide / 43) / 220 + nitrogenOxides(air) +
                       sumOver(air, &Irritant::lethal);
  const double dioxide = air.percent(Air::kCarbonDioxide);
  const double breathing = dioxide > 0 ? std::exp(0.1903 * dioxide + 2.0004) / 7.1 : 1;
  const double oxygen = air.percent(Air::kOxygen);
  return gases * breathing + (oxygen < 20 ? lowOxygen(oxygen) : 0);
}

double smokeviewGas(const Exposure& air) {
  constexpr double kMax = 10, kMaxOxygen = 20;  // [%]
  const double monoxide = std::min(air.percent(Air::kCarbonMonoxide), kMax) * 1e4;
  const double dioxide = std::min(air.percent(Air::kCarbonDioxide), kMax);
  return fdsCarbonMonoxide(monoxide, Activity::kLight) * std::exp(0.1930 * dioxide + 2.0004) / 7.1 +
         lowOxygen(std::min(air.percent(Air::kOxygen), kMaxOxygen));
}

constexpr double kHarmlessFlux = 2.5;  // [kW/m2], ISO 13571:2012, 8

double isoHeat(const Exposure& air, const DosePerson& person) {
  const double degrees = std::max(air[Air::kTemperature], 0.0);
  const double flux = air[Air::kRadiantFlux];
  const double convective = person.clothing == Clothing::kClothed ? std::pow(degrees, 3.61) / 4.1e8
                                                                  : std::pow(degrees, 3.4) / 5e7;
  const double radiant =
      person.burns == BurnEndpoint::kPain ? std::pow(flux, 1.9) / 4.2 : std::pow(flux, 1.56) / 6.9;
  return convective + (flux > kHarmlessFlux ? radiant : 0);
}

double sfpeHeat(const Exposure& air) {
  const double flux = air[Air::kRadiantFlux];
  return std::pow(std::max(air[Air::kTemperature], 0.0), 3.4) / 5e7 +
         (flux > kHarmlessFlux ? std::pow(flux, 1.33) / 1.33 : 0);
}

constexpr std::size_t kDoseLaws = 8;

bool lacks(DoseLaw law, const Exposure& air) {
  const auto unknown = [&](Air one) { return std::isnan(air[one]); };
  static const auto kNeeded = [] {
    std::array<std::vector<Air>, kDoseLaws> needed;
    for (std::size_t i = 0; i < needed.size(); ++i)
      needed[i] = volute::needed(static_cast<DoseLaw>(i));
    return needed;
  }();
  const auto& all = kNeeded[static_cast<std::size_t>(law)];
  if (isInstantaneous(law))
    return std::ranges::all_of(all, unknown);
  return std::ranges::any_of(all, unknown);
}

constexpr std::string_view kQuoted =
    "the documentation of pyFDS-Evac (Fundamentals), which quotes it by equation and page; the "
    "book "
    "itself was not at hand";

}  // namespace

std::span<const DoseLawInfo> doseLaws() {
  static constexpr std::array<DoseLawInfo, kDoseLaws> laws{{
      {DoseLaw::kIsoGas, "iso-13571", "fed-gas",
       "ISO 13571:2012, 6.1: CO 35000 ppm min, HCN^2.36 / 1.2e6, times exp(CO2 / 5)",
       "35000 ppm min: the documentation of pyFDS-Evac and the source of BRANZFIRE; the HCN term "
       "is "
       "the handbook's 63.24; the standard itself was not at hand"},
      {DoseLaw::kSfpeGas, "sfpe", "fed-gas",
       "SFPE Handbook, 5th ed., ch. 63 (Purser and McAllister 2016), eq. 63.38 with 63.15, 63.18, "
       "63.24, 63.35, 63.50",
       kQuoted},
      {DoseLaw::kFdsGas, "fds", "fed-gas", "FDS User's Guide, FED; func.f90 of FDS",
       "a worked example of pyFDS-Evac: CO 0.10 %, CO2 2.0 %, O2 15.0 % reach 1 at 981.7 s"},
      {DoseLaw::kSmokeviewGas, "smokeview", "fed-gas", "Smokeview's source, FED slices (ReadFed)",
       "figures of Smokeview's Verification Guide (fed_test)"},
      {DoseLaw::kIsoHeat, "iso-13571", "fed-heat", "ISO 13571:2012, 8, eqs. 7 to 10", kQuoted},
      {DoseLaw::kSfpeHeat, "sfpe", "fed-heat",
       "SFPE Handbook, 5th ed., ch. 63, eqs. 63.43 (r = 1.33) and 63.44", kQuoted},
      {DoseLaw::kIsoIrritants, "iso-13571", "fec", "ISO 13571:2012, 6.2.1, eq. 4", kQuoted},
      {DoseLaw::kSfpeIrritants, "sfpe", "fec",
       "SFPE Handbook, 5th ed., ch. 63, eq. 63.11 with table 63.6, escape impairment", kQuoted},
  }};
  return laws;
}

const DoseLawInfo& infoOf(DoseLaw law) {
  return doseLaws()[static_cast<std::size_t>(law)];
}

bool isInstantaneous(DoseLaw law) {
  return law == DoseLaw::kIsoIrritants || law == DoseLaw::kSfpeIrritants;
}

std::vector<Air> needed(DoseLaw law) {
  switch (law) {
    case DoseLaw::kIsoHeat:
    case DoseLaw::kSfpeHeat:
      return {Air::kTemperature};
    case DoseLaw::kIsoIrritants:
    case DoseLaw::kSfpeIrritants: {
      std::vector<Air> gases;
      for (const Irritant& irritant : kIrritants) gases.push_back(irritant.gas);
      return gases;
    }
    case DoseLaw::kSmokeviewGas:
      return {Air::kCarbonMonoxide, Air::kCarbonDioxide, Air::kOxygen};
    default:
      return {Air::kCarbonMonoxide};
  }
}

std::vector<Air> taken(DoseLaw law) {
  switch (law) {
    case DoseLaw::kIsoHeat:
    case DoseLaw::kSfpeHeat:
      return {Air::kRadiantFlux};
    case DoseLaw::kIsoGas:
      return {Air::kCarbonDioxide, Air::kHydrogenCyanide};
    case DoseLaw::kSfpeGas:
    case DoseLaw::kFdsGas: {
      std::vector<Air> gases{Air::kCarbonDioxide, Air::kOxygen, Air::kHydrogenCyanide,
                             Air::kNitricOxide};
      for (const Irritant& irritant : kIrritants) gases.push_back(irritant.gas);
      return gases;
    }
    default:
      return {};
  }
}

double doseRate(DoseLaw law, const DosePerson& person, const Exposure& known) {
  if (lacks(law, known))
    return std::numeric_limits<double>::quiet_NaN();
  const Exposure air = completed(known);
  switch (law) {
    case DoseLaw::kIsoGas:
      return isoGas(air) / kMinute;
    case DoseLaw::kSfpeGas:
      return sfpeGas(air, person.activity) / kMinute;
    case DoseLaw::kFdsGas:
      return fdsGas(air, person.activity) / kMinute;
    case DoseLaw::kSmokeviewGas:
      return smokeviewGas(air) / kMinute;
    case DoseLaw::kIsoHeat:
      return isoHeat(air, person) / kMinute;
    case DoseLaw::kSfpeHeat:
      return sfpeHeat(air) / kMinute;
    case DoseLaw::kIsoIrritants:
      return sumOver(air, &Irritant::iso);
    case DoseLaw::kSfpeIrritants:
      return sumOver(air, &Irritant::escape);
  }
  return 0;
}

}  // namespace volute
