// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/smoke/smoke_words.hpp"

#include <fmt/format.h>

#include <cmath>

#include "volute/io/unit.hpp"

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

std::string compareUnitInName(std::string_view field, const SmokeModel& model) {
  const std::size_t open = field.find_last_of("[(");
  if (open == field.npos || !(field.ends_with(']') || field.ends_with(')')))
    return "";
  const std::string_view stated = field.substr(open + 1, field.size() - open - 2);
  const std::string read = unitOfField(model);
  if (stated.empty() || !isUnit(stated) || !isUnit(read))
    return "";
  const auto change = unitChange(stated, read);
  if (!change)
    return fmt::format("its name states {}, and it is read as {} [{}]", stated,
                       nameOf(model.quantity), read);
  const double factor = (*change)(1.0) - (*change)(0.0);
  if (std::abs(factor - model.scale) <= 1e-6 * factor)
    return "";
  return fmt::format(
      "its name states {}, of which one is {:g} {}, and it is read with a factor of "
      "{:g}",
      stated, factor, read, model.scale);
}

std::string textOfDimensions(const std::array<double, 7>& dimensions) {
  static constexpr std::array<const char*, 7> kUnits = {"kg", "m", "s", "K", "mol", "A", "cd"};
  std::string words;
  for (std::size_t i = 0; i < dimensions.size(); ++i) {
    if (dimensions[i] != 0)
      words += fmt::format("{}{}{}", words.empty() ? "" : " ", kUnits[i],
                           dimensions[i] == 1 ? "" : fmt::format("^{:g}", dimensions[i]));
  }
  return words.empty() ? "no dimensions" : words;
}

Result<std::string> compareDimensions(const std::array<double, 7>& stated, const SmokeModel& model,
                                      const std::string& where) {
  std::array<double, 7> expected{};
  switch (model.quantity) {
    case SmokeQuantity::kSootDensity:
    case SmokeQuantity::kProductsDensity:
      expected[0] = 1, expected[1] = -3;
      break;
    case SmokeQuantity::kMassFraction:
      break;
    case SmokeQuantity::kExtinction:
    case SmokeQuantity::kOpticalDensity:
    case SmokeQuantity::kOpticalDensityDb:
      expected[1] = -1;
      break;
    case SmokeQuantity::kVisibility:
      expected[1] = 1;
      break;
  }
  constexpr std::array<double, 7> kNone{};
  if (stated == expected) {
    if (!holdsMass(model.quantity) || model.quantity == SmokeQuantity::kMassFraction ||
        model.unit == 1)
      return std::string();
    return fmt::format("{}: the file states {} (SI), and its values are read as {}", where,
                       textOfDimensions(stated), unitOfField(model));
  }
  if (stated == kNone)
    return fmt::format("{}: the file states a number without dimensions; it is read as {} [{}]",
                       where, nameOf(model.quantity), unitOfField(model));
  return fail(ErrorCode::kInvalidData,
              "{}: the file states {}, and {} has {}; choose the quantity that the field holds",
              where, textOfDimensions(stated), nameOf(model.quantity), textOfDimensions(expected));
}

}  // namespace volute
