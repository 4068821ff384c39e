// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tenability/criterion.hpp"

namespace volute {
namespace {

constexpr const char* kThird =
    "FED and FEC of 0.3: ISO 13571:2012, 5.4 and A.5.2 (11.4 % of the people are affected below "
    "it), "
    "as quoted by the documentation of pyFDS-Evac; the standard itself was not at hand";

/// Read as an official information request to the ministry quotes both clauses.
constexpr const char* kZealand =
    "New Zealand Building Code, clause C4.3 (a) to (c), as quoted in fyi.org.nz request 3477 "
    "(2015)";

/// What the clause leaves open is as C/VM2 has it.
constexpr const char* kZealandModel =
    "; C = 3, the models of doses and 2 m above the floor: C/VM2, whose text was not at hand";

Criterion dose(const char* name, DoseLaw law, const char* source = kThird) {
  return {.name = name, .law = law, .person = {}, .limit = 0.3, .source = source};
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

std::span<const CriteriaProfile> criteriaProfiles() {
  constexpr const char* kIso =
      "ISO 13571:2012, as quoted by the documentation of pyFDS-Evac; the standard itself was not "
      "at "
      "hand";
  constexpr double kSmallRoom = 100;  // [m2]
  static const std::vector<CriteriaProfile> profiles = [&] {
    std::vector<CriteriaProfile> all;
    all.push_back(
        {"usual",
         "Usual criteria of several guides",
         "each criterion has its own source",
         "a first look: no guide asks for all of them together",
         {level("visibility", Air::kExtinction, 0.3,
                "10 m of sight where one stands, C = 3 (K = 0.3 1/m): Purser, PD 7974-6, CIBSE "
                "Guide E"),
          level("temperature", Air::kTemperature, 60,
                "60 degrees C for some minutes, as NFPA 130 and vfdb guides have it"),
          level("radiant-flux", Air::kRadiantFlux, 2.5,
                "2.5 kW/m2: ISO 13571:2012, 8.2, as quoted by the documentation of pyFDS-Evac"),
          dose("fed-gas-iso", DoseLaw::kIsoGas), dose("fed-gas-sfpe", DoseLaw::kSfpeGas),
          dose("fed-heat", DoseLaw::kIsoHeat), dose("fec", DoseLaw::kIsoIrritants)}});
    all.push_back({"iso-13571",
                   "ISO 13571: compromised tenability at 0.3",
                   kIso,
                   "adults of average susceptibility; 11.4 % of the people are affected below 0.3. "
                   "The standard names no distance of sight: none is in this profile",
                   {dose("fed-gas", DoseLaw::kIsoGas), dose("fed-heat", DoseLaw::kIsoHeat),
                    dose("fec", DoseLaw::kIsoIrritants)}});
    Criterion gas = dose("fed-co", DoseLaw::kSfpeGas, kZealand);
    gas.applies = "carbon monoxide, with what carbon dioxide and low oxygen add to it";
    Criterion heat = dose("fed-thermal", DoseLaw::kIsoHeat, kZealand);
    Criterion far = level("visibility-10-m", Air::kExtinction, 0.3, kZealand);
    far.applies = "rooms of 100 m2 and more, and where no room is known; 10 m with C = 3";
    far.roomFrom = kSmallRoom;
    Criterion near = level("visibility-5-m", Air::kExtinction, 0.6, kZealand);
    near.applies = "rooms of less than 100 m2; 5 m with C = 3";
    near.roomBelow = kSmallRoom;
    for (Criterion* one : {&gas, &heat, &far, &near}) one->checked = true;
    all.push_back({"nz-c4.3",
                   "New Zealand Building Code C4.3 (C/VM2)",
                   std::string(kZealand) + kZealandModel,
                   "buildings in New Zealand, at 2 m above the floor",
                   {gas, heat, far, near}});
    all.push_back(
        {"nz-c4.4",
         "New Zealand Building Code C4.4 (C/VM2): sprinklers",
         "New Zealand Building Code, clause C4.4, as quoted in fyi.org.nz request 3477 (2015): "
         "C4.3 (b) and (c) do not apply" +
             std::string(kZealandModel),
         "firecells with an automatic sprinkler system in which it is not possible to expose more "
         "than 1000 people: heat and visibility are not asked for there",
         {gas}});
    return all;
  }();
  return profiles;
}

const std::vector<Criterion>& usualCriteria() {
  return criteriaProfiles().front().criteria;
}

}  // namespace volute
