// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tenability/criterion.hpp"

namespace volute {
namespace {

constexpr const char* kThird =
    "FED and FEC of 0.3: ISO 13571:2012, 5.4 and A.5.2 (11.4 % of the people are affected below "
    "it), "
    "as quoted by the documentation of pyFDS-Evac; the standard itself was not at hand";

Criterion dose(const char* name, DoseLaw law) {
  return {.name = name, .law = law, .person = {}, .limit = 0.3, .source = kThird};
}

Criterion level(const char* name, Air quantity, double limit, const char* source,
                bool falling = false) {
  return {.name = name,
          .law = {},
          .quantity = quantity,
          .person = {},
          .limit = limit,
          .falling = falling,
          .source = source};
}

}  // namespace

std::string Criterion::unit() const {
  return law ? "" : std::string(quantityOf(quantity).unit);
}

std::string Criterion::words() const {
  if (!law) {
    return fmt::format("{} {} {:g} {}", quantityOf(quantity).name, falling ? "<=" : ">=", limit,
                       quantityOf(quantity).unit);
  }
  const DoseLawInfo& info = infoOf(*law);
  return fmt::format("{} ({}) >= {:g}", info.kind, info.name, limit);
}

double Criterion::value(const Exposure& air) const {
  return law ? doseRate(*law, person, air) : air[quantity];
}

std::vector<Air> Criterion::needed() const {
  return law ? volute::needed(*law) : std::vector{quantity};
}

std::vector<Air> Criterion::taken() const {
  return law ? volute::taken(*law) : std::vector<Air>{};
}

const std::vector<Criterion>& usualCriteria() {
  static const std::vector<Criterion> criteria{
      level(
          "visibility", Air::kExtinction, 0.3,
          "10 m of sight where one stands, C = 3 (K = 0.3 1/m): Purser, PD 7974-6, CIBSE Guide E"),
      level("temperature", Air::kTemperature, 60,
            "60 degrees C for some minutes, as NFPA 130 and vfdb guides have it"),
      level("radiant-flux", Air::kRadiantFlux, 2.5,
            "2.5 kW/m2: ISO 13571:2012, 8.2, as quoted by the documentation of pyFDS-Evac"),
      dose("fed-gas-iso", DoseLaw::kIsoGas),
      dose("fed-gas-sfpe", DoseLaw::kSfpeGas),
      dose("fed-heat", DoseLaw::kIsoHeat),
      dose("fec", DoseLaw::kIsoIrritants),
  };
  return criteria;
}

}  // namespace volute
