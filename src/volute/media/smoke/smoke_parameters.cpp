// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// What a person may change about smoke.
#include <algorithm>

#include "volute/media/smoke/smoke_scene_medium.hpp"
#include "volute/optics/smoke_potential.hpp"

namespace volute {
namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr const char* kAlbedoHelp = "share of the extinction that scatters light; the rest absorbs";
constexpr int kExtinctionPlace = 2;  ///< its place

std::vector<std::string> smokeQuantities() {
  return {"soot-density",    "products-density",   "extinction",
          "optical-density", "optical-density-db", "visibility"};
}

/// What a field means is doubted where no fire has as much soot, or as little; the meanings that
/// make sense are offered.
struct Doubt {
  std::string text{};
  std::vector<int> units{};  ///< places in kUnits
  bool extinction = false;   ///< its values make sense as 1/m
};

constexpr const char* kUnits[] = {"kg/m3", "g/m3", "mg/m3"};
constexpr double kUnitKilograms[] = {1, 1e-3, 1e-6};

Doubt doubtOf(const SmokeModel& model, double largestExtinction) {
  constexpr double kFaint = 0.01, kThick = 50;  // [1/m] that smoke may have
  const double soot = largestExtinction > 0 ? model.sootDensity(largestExtinction) : 0;
  const auto usual = [](double density) {
    return density >= SmokeLayer::kLittleSoot && density <= SmokeLayer::kMuchSoot;
  };
  if (!(soot > 0) || usual(soot))
    return {};
  Doubt doubt{.text = fmt::format("up to {:.2g} kg/m3 of soot, {} for a fire", soot,
                                  soot > SmokeLayer::kMuchSoot ? "much" : "little")};
  for (int i = 0; i < 3; ++i) {
    if (kUnitKilograms[i] != model.unit && usual(soot * kUnitKilograms[i] / model.unit))
      doubt.units.push_back(i);
  }
  const double largest = soot / model.unit;  // of soot, times its scale
  doubt.extinction =
      model.quantity == SmokeQuantity::kSootDensity && largest >= kFaint && largest <= kThick;
  return doubt;
}

/// What a field's new meaning needs, and what it must not have.
void takeQuantity(OrderedJson& smoke, const std::string& quantity) {
  for (const char* key : {"material", "burning", "smoke_potential", "soot_yield", "density_field"})
    smoke.erase(key);
  if (quantity != "soot-density")
    smoke.erase("mass_extinction");
  if (quantity != "soot-density" && quantity != "products-density")
    smoke.erase("unit");
  smoke["quantity"] = quantity;
  if (quantity == "products-density")
    smoke["smoke_potential"] = 1.0;
}

}  // namespace

void addSmokeParameters(ParameterGroup group, const SmokeDescription& smoke, bool fds,
                        double largestExtinction, const MediumInfo& info) {
  const SmokeModel& model = smoke.model;
  const Doubt doubt = doubtOf(model, largestExtinction);
  if (!fds && model.quantity != SmokeQuantity::kMassFraction) {
    Parameter& quantity =
        group.choice("field holds", "quantity", smokeQuantities(), nameOf(model.quantity));
    quantity.help = "what its values mean; of concentrations also the unit below";
    if (doubt.extinction) {
      quantity.doubt = doubt.text + ": does the field hold";
      quantity.offers = {kExtinctionPlace};
    }
  }
  const bool soot = model.quantity == SmokeQuantity::kSootDensity;
  const bool products = model.quantity == SmokeQuantity::kProductsDensity;
  if (!fds && (soot || products)) {
    const auto held = std::ranges::find(kUnitKilograms, model.unit) - kUnitKilograms;
    Parameter& unit = group.choice("unit", "unit", {std::begin(kUnits), std::end(kUnits)},
                                   kUnits[held == std::ssize(kUnits) ? 0 : held]);
    if (!doubt.units.empty()) {
      unit.doubt = doubt.extinction ? "or is its unit" : doubt.text + ": is its unit";
      unit.offers = doubt.units;
    }
  }
  group.amount("scale", "scale", model.scale, 10, "x").help =
      "the field is multiplied by this before anything else";
  if (products) {
    const double potential =
        model.smokePotential.value_or(smokePotential(model.massExtinction, model.sootYield));
    group.amount("smoke potential", "smoke_potential", potential, 10, "dB m2/g").help =
        "of what burns; the list has that of materials";
    std::vector<std::string> materials{"-"};
    std::string_view of = "-";
    for (const SmokePotential& entry : smokePotentials()) {
      materials.emplace_back(entry.material);
      if (entry.flaming == potential)
        of = entry.material;
    }
    group.choice("material", "material", std::move(materials), of).help =
        "takes its smoke potential when flaming";
  } else if (fds || soot || model.quantity == SmokeQuantity::kMassFraction) {
    group.range("Km", "mass_extinction", model.massExtinction, 1000, 15000, "m2/kg").help =
        fds ? "extinction of 1 kg/m3 of soot; where the case holds opacity or extinction it says "
              "nothing"
            : "extinction of 1 kg/m3 of soot, natural logarithm";
  }
  group.choice("mode", "mode", {"photometric", "threshold"}, nameOf(smoke.law.mode)).help =
      "threshold: what has faded to a tenth is no longer seen";
  group.range("C", "C", smoke.law.c, 1, 10).help = "visibility = C / K: 3 reflecting, 8 emitting";
  group.add("albedo", "albedo", Parameter::Kind::kColor, {smoke.albedo[0], smoke.albedo[1], smoke.albedo[2]}).help = kAlbedoHelp;
  group.clock(smoke.clock, info);
}

bool setSmokeParameter(OrderedJson& entry, const std::string& key, const OrderedJson& value) {
  if (key == "quantity") {
    takeQuantity(entry, value.get<std::string>());
    return true;
  }
  if (key != "smoke_potential" && key != "material")
    return false;
  for (const char* other : {"material", "burning", "soot_yield", "mass_extinction"})
    entry.erase(other);
  if (key == "smoke_potential")
    entry[key] = value;
  else if (const auto potential = smokePotentialOf(value.get<std::string>()))
    entry["smoke_potential"] = potential->flaming;
  return true;
}

}  // namespace volute
