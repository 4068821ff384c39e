// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/smoke/smoke_words.hpp"

#include <fmt/format.h>

namespace volute {
namespace {

using enum SmokeQuantity;

std::string densityName(double unit) {
  for (const char* name : {"kg/m3", "g/m3", "mg/m3"}) {
    if (densityUnit(name) == unit)
      return name;
  }
  return fmt::format("{:g} kg/m3", unit);
}

}  // namespace

bool holdsMass(SmokeQuantity quantity) {
  return quantity == kSootDensity || quantity == kProductsDensity || quantity == kMassFraction;
}

std::string unitOfField(const SmokeModel& model) {
  switch (model.quantity) {
    case kSootDensity:
    case kProductsDensity:
      return densityName(model.unit);
    case kMassFraction:
      return "kg/kg";
    case kOpticalDensityDb:
      return "dB/m";
    case kVisibility:
      return "m";
    case kExtinction:
    case kOpticalDensity:
      break;
  }
  return "1/m";
}

std::string unitOfConcentration(const SmokeModel& model) {
  if (!holdsMass(model.quantity))
    return "";
  return model.quantity == kMassFraction ? "kg/m3" : densityName(model.unit);
}

double extinctionOfConcentration(const SmokeModel& model) {
  return holdsMass(model.quantity) ? model.extinction(1 / model.scale) : 0;
}

std::vector<std::string> wordsOf(const SmokeModel& model) {
  std::vector<std::string> words{
      fmt::format("{} [{}]", nameOf(model.quantity), unitOfField(model))};
  if (model.scale != 1)
    words.push_back(fmt::format("scale {:g}", model.scale));
  if (model.quantity == kProductsDensity && model.smokePotential) {
    words.push_back(fmt::format("P = {:g} dB m2/g", *model.smokePotential));
  } else if (holdsMass(model.quantity)) {
    words.push_back(fmt::format("Km = {:g} m2/kg", model.massExtinction));
    if (model.quantity == kProductsDensity)
      words.push_back(fmt::format("ys = {:g}", model.sootYield));
  } else if (model.quantity == kVisibility) {
    words.push_back(fmt::format("K = C / S, C = {:g}", model.c));
  }
  return words;
}

}  // namespace volute
