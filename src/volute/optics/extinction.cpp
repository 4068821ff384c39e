// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/optics/extinction.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

namespace volute {
namespace {

constexpr double kLn10 = std::numbers::ln10;

constexpr std::array<std::string_view, 7> kNames{
    "soot-density",    "products-density",   "mass-fraction", "extinction",
    "optical-density", "optical-density-db", "visibility"};

Status positive(double value, std::string_view what) {
  if (value > 0 && std::isfinite(value))
    return {};
  return fail(ErrorCode::kInvalidArgument, "{} is {}; expected a finite number > 0", what, value);
}

bool isMass(SmokeQuantity quantity) {
  return quantity == SmokeQuantity::kSootDensity || quantity == SmokeQuantity::kProductsDensity ||
         quantity == SmokeQuantity::kMassFraction;
}

}  // namespace

std::string_view nameOf(SmokeQuantity quantity) {
  return kNames[static_cast<std::size_t>(quantity)];
}

Result<SmokeQuantity> smokeQuantity(std::string_view name) {
  std::string all;
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    if (kNames[i] == name)
      return static_cast<SmokeQuantity>(i);
    all += (i ? ", " : "") + std::string(kNames[i]);
  }
  return fail(ErrorCode::kInvalidArgument, "smoke quantity '{}': expected one of {}", name, all);
}

Result<double> densityUnit(std::string_view name) {
  if (name == "kg/m3")
    return 1.0;
  if (name == "g/m3")
    return 1e-3;
  if (name == "mg/m3")
    return 1e-6;
  return fail(ErrorCode::kInvalidArgument, "unit '{}': expected kg/m3, g/m3 or mg/m3", name);
}

Status SmokeModel::check() const {
  VOLUTE_TRY(positive(scale, "the scale of the smoke field"));
  VOLUTE_TRY(positive(unit, "the unit of the smoke field"));
  if (isMass(quantity))
    VOLUTE_TRY(positive(massExtinction, "the mass extinction [m2/kg]"));
  if (quantity == SmokeQuantity::kVisibility)
    VOLUTE_TRY(positive(c, "C of the visibility"));
  if (quantity != SmokeQuantity::kProductsDensity)
    return {};
  if (smokePotential)
    return positive(*smokePotential, "the smoke potential [dB m2/g]");
  if (sootYield > 0 && sootYield <= 1)
    return {};
  return fail(ErrorCode::kInvalidArgument,
              "products-density needs a soot yield (mass of soot per mass burnt, 0 to 1) or a "
              "material; the soot yield is {}",
              sootYield);
}

double SmokeModel::extinction(double value, double gasDensity) const {
  const double v = value * scale;
  switch (quantity) {
    case SmokeQuantity::kSootDensity:
      return massExtinction * unit * v;
    case SmokeQuantity::kProductsDensity:
      return (smokePotential ? productsExtinction(*smokePotential) : massExtinction * sootYield) *
             unit * v;
    case SmokeQuantity::kMassFraction:
      return massExtinction * gasDensity * v;
    case SmokeQuantity::kExtinction:
      return v;
    case SmokeQuantity::kOpticalDensity:
      return kLn10 * v;
    case SmokeQuantity::kOpticalDensityDb:
      return 0.1 * kLn10 * v;
    case SmokeQuantity::kVisibility:
      return c / v;
  }
  return 0;
}

void SmokeModel::extinction(std::span<const float> values, std::span<const float> gasDensity,
                            std::span<float> out) const {
  for (std::size_t i = 0; i < values.size(); ++i) {
    out[i] = static_cast<float>(
        extinction(values[i], gasDensity.empty() ? 1.0 : static_cast<double>(gasDensity[i])));
  }
}

double opticalDensity(double extinction) {
  return extinction / kLn10;
}

double opticalDensityDb(double extinction) {
  return 10 * extinction / kLn10;
}

double obscuration(double extinction, double length) {
  return -std::expm1(-extinction * length);
}

double productsExtinction(double smokePotential) {
  return 1000 * 0.1 * kLn10 * smokePotential;  // dB m2/g to m2/kg
}

double smokePotential(double massExtinction, double sootYield) {
  return 10 / kLn10 * (massExtinction / 1000) * sootYield;
}

}  // namespace volute
