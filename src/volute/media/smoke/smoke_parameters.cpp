// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/smoke/smoke_parameters.hpp"

#include <algorithm>
#include <initializer_list>
#include <nlohmann/json.hpp>

#include "volute/base/lower_case.hpp"
#include "volute/media/smoke/smoke_medium.hpp"
#include "volute/optics/smoke_potential.hpp"

namespace volute {
namespace {

const SmokeModel& modelOf(const void* smoke) {
  return static_cast<const SmokeDescription*>(smoke)->model;
}

/// What a field means is doubted where no fire has as much soot, or as little; the meanings that
/// make sense are offered.
struct Doubt {
  std::string text{};
  std::vector<int> units{};  ///< places among the choices
  bool extinction = false;   ///< its values make sense as 1/m
};

constexpr double kUnitKilograms[] = {1, 1e-3, 1e-6};
constexpr const char* kUnitNames[] = {"kg/m3", "g/m3", "mg/m3"};  ///< the choices, in order

Doubt doubtOf(const SmokeModel& model, const MediumFacts& facts) {
  constexpr double kFaint = 0.01, kThick = 50;  // [1/m] that smoke may have
  const double soot = facts.largestExtinction > 0 ? model.sootDensity(facts.largestExtinction) : 0;
  const auto usual = [](double density) {
    return density >= SmokeMedium::kLittleSoot && density <= SmokeMedium::kMuchSoot;
  };
  if (!(soot > 0) || usual(soot))
    return {};
  Doubt doubt{.text = fmt::format("up to {:.2g} kg/m3 of soot, {} for a fire", soot,
                                  soot > SmokeMedium::kMuchSoot ? "much" : "little")};
  for (int i = 0; i < 3; ++i) {
    if (kUnitKilograms[i] != model.unit && usual(soot * kUnitKilograms[i] / model.unit))
      doubt.units.push_back(i);
  }
  const double largest = soot / model.unit;  // of soot, times its scale
  doubt.extinction =
      model.quantity == SmokeQuantity::kSootDensity && largest >= kFaint && largest <= kThick;
  return doubt;
}

Parameter& addRow(ParameterGroup& group, const char* name, const void* smoke) {
  const FieldRow& row = smokeFields().at(name);
  return group.add(row, name, row.access.get(row, smoke));
}

}  // namespace

void addQuantity(ParameterGroup& group, const void* smoke, const MediumFacts& facts) {
  if (modelOf(smoke).quantity == SmokeQuantity::kMassFraction)
    return;  // it needs another field
  Parameter& quantity = addRow(group, "quantity", smoke);
  const std::string chosen = quantity.choices[static_cast<std::size_t>(quantity.value.front())];
  std::erase(quantity.choices, nameOf(SmokeQuantity::kMassFraction));
  const auto place = [&](std::string_view name) {
    return static_cast<int>(std::ranges::find(quantity.choices, name) - quantity.choices.begin());
  };
  quantity.value = {static_cast<double>(place(chosen))};
  quantity.most = static_cast<double>(quantity.choices.size()) - 1;
  const Doubt doubt = doubtOf(modelOf(smoke), facts);
  if (doubt.extinction) {
    quantity.doubt = doubt.text + ": does the field hold";
    quantity.offers = {place(nameOf(SmokeQuantity::kExtinction))};
  }
}

void addUnit(ParameterGroup& group, const void* smoke, const MediumFacts& facts) {
  const SmokeQuantity quantity = modelOf(smoke).quantity;
  if (quantity != SmokeQuantity::kSootDensity && quantity != SmokeQuantity::kProductsDensity)
    return;
  Parameter& unit = addRow(group, "unit", smoke);
  const Doubt doubt = doubtOf(modelOf(smoke), facts);
  if (!doubt.units.empty()) {
    unit.doubt = doubt.extinction ? "or is its unit" : doubt.text + ": is its unit";
    unit.offers = doubt.units;
  }
}

void addPotential(ParameterGroup& group, const void* smoke, const MediumFacts& /*facts*/) {
  const SmokeModel& model = modelOf(smoke);
  if (model.quantity != SmokeQuantity::kProductsDensity)
    return;
  const double potential =
      model.smokePotential.value_or(smokePotential(model.massExtinction, model.sootYield));
  group.add(smokeFields().at("smoke_potential"), "smoke_potential", potential).help =
      "of what burns; the list has that of materials";
  std::vector<std::string_view> materials{"-"};
  std::string_view of = "-";
  for (const SmokePotential& entry : smokePotentials()) {
    materials.emplace_back(entry.material);
    if (entry.flaming == potential)
      of = entry.material;
  }
  group.choice("material", "material", materials, of).help =
      "takes its smoke potential when flaming";
}

std::string guessSmoke(nlohmann::ordered_json& smoke, const SmokeMedium& medium) {
  const Doubt doubt =
      doubtOf(medium.description().model, {.largestExtinction = medium.largestExtinction()});
  if (doubt.text.empty())
    return "";
  const std::string name = lowerCase(medium.fieldName());
  const auto says = [&](std::initializer_list<const char*> words) {
    return std::ranges::any_of(
        words, [&](const char* word) { return name.find(word) != std::string::npos; });
  };
  const bool mass = says({"soot", "dens", "mass", "rho", "conc"});
  const bool optical = says({"ext", "kappa", "sigma", "1/m", "beta"});
  if (doubt.extinction && (optical || !mass)) {
    setSmoke(smoke, "quantity", "extinction");
    return fmt::format(
        "field '{}' is taken for extinction in 1/m, unless you say otherwise: as soot "
        "in kg/m3 it would be {}",
        medium.fieldName(), doubt.text);
  }
  if (doubt.units.empty())
    return "";
  const char* const unit = kUnitNames[doubt.units.front()];
  smoke["unit"] = unit;
  return fmt::format(
      "field '{}' is taken for soot in {}, unless you say otherwise: in kg/m3 it would "
      "be {}",
      medium.fieldName(), unit, doubt.text);
}

bool setSmoke(nlohmann::ordered_json& smoke, const std::string& key,
              const nlohmann::ordered_json& value) {
  if (key == "quantity") {
    for (const char* other :
         {"material", "burning", "smoke_potential", "soot_yield", "density_field"})
      smoke.erase(other);
    if (value != "soot-density")
      smoke.erase("mass_extinction");
    if (value != "soot-density" && value != "products-density")
      smoke.erase("unit");
    smoke[key] = value;
    if (value == "products-density")
      smoke["smoke_potential"] = 1.0;
    return true;
  }
  if (key != "smoke_potential" && key != "material")
    return false;
  for (const char* other : {"material", "burning", "soot_yield", "mass_extinction"})
    smoke.erase(other);
  if (key == "smoke_potential")
    smoke[key] = value;
  else if (const auto entry = smokePotentialOf(value.get<std::string>()))
    smoke["smoke_potential"] = entry->flaming;
  return true;
}

}  // namespace volute
