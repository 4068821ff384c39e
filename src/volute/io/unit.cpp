// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/unit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <utility>

#include "volute/base/number_word.hpp"
#include "volute/base/printable.hpp"
#include "volute/io/table_row.hpp"

namespace volute {
namespace {

/// Exponents of metre, kilogram, second, kelvin and mole.
using Dimension = std::array<int, 5>;

constexpr Dimension kNone{}, kLength{1}, kMass{0, 1}, kTime{0, 0, 1}, kTemperature{0, 0, 0, 1},
    kAmount{0, 0, 0, 0, 1}, kEnergy{2, 1, -2}, kPower{2, 1, -3}, kPressure{-1, 1, -2},
    kForce{1, 1, -2}, kVolume{3};

struct Unit {
  Dimension dimension{};
  char share = 0;  ///< of a fraction: 'a' of amount or volume, 'm' of mass
  double factor = 1;
  double offset = 0;  ///< SI = factor * value + offset
};

struct NamedUnit {
  std::string_view name;
  Unit unit;
  std::string_view prefixes = "";  ///< that may stand before it; u for micro
};

constexpr NamedUnit kUnits[] = {
    {"m", {kLength}, "numcdk"},
    {"g", {kMass, 0, 1e-3}, "numkM"},
    {"t", {kMass, 0, 1e3}},
    {"s", {kTime}, "num"},
    {"min", {kTime, 0, 60}},
    {"h", {kTime, 0, 3600}},
    {"K", {kTemperature}, "m"},
    {"mol", {kAmount}, "numk"},
    {"W", {kPower}, "umkMG"},
    {"J", {kEnergy}, "mkMG"},
    {"Pa", {kPressure}, "hkM"},
    {"bar", {kPressure, 0, 1e5}, "m"},
    {"N", {kForce}, "mkM"},
    {"l", {kVolume, 0, 1e-3}, "umcd"},
    {"L", {kVolume, 0, 1e-3}, "umcd"},
    {"ft", {kLength, 0, 0.3048}},
    {"in", {kLength, 0, 0.0254}},
    {"1", {kNone}},
};

constexpr double kFahrenheit = 5.0 / 9;

/// Of the whole text, in lower case.
constexpr NamedUnit kWords[] = {
    {"", {kNone}},
    {"-", {kNone}},
    {"%", {kNone, 0, 1e-2}},
    {"percent", {kNone, 0, 1e-2}},
    {"vol%", {kNone, 'a', 1e-2}},
    {"vol.%", {kNone, 'a', 1e-2}},
    {"vol.-%", {kNone, 'a', 1e-2}},
    {"vol-%", {kNone, 'a', 1e-2}},
    {"mol%", {kNone, 'a', 1e-2}},
    {"ppm", {kNone, 0, 1e-6}},
    {"ppmv", {kNone, 'a', 1e-6}},
    {"ppb", {kNone, 0, 1e-9}},
    {"c", {kTemperature, 0, 1, 273.15}},
    {"°c", {kTemperature, 0, 1, 273.15}},
    {"degc", {kTemperature, 0, 1, 273.15}},
    {"deg c", {kTemperature, 0, 1, 273.15}},
    {"degrees c", {kTemperature, 0, 1, 273.15}},
    {"celsius", {kTemperature, 0, 1, 273.15}},
    {"f", {kTemperature, 0, kFahrenheit, 459.67 * kFahrenheit}},
    {"°f", {kTemperature, 0, kFahrenheit, 459.67 * kFahrenheit}},
    {"degf", {kTemperature, 0, kFahrenheit, 459.67 * kFahrenheit}},
    {"deg f", {kTemperature, 0, kFahrenheit, 459.67 * kFahrenheit}},
    {"fahrenheit", {kTemperature, 0, kFahrenheit, 459.67 * kFahrenheit}},
    {"kelvin", {kTemperature}},
    {"metre", {kLength}},
    {"metres", {kLength}},
    {"meter", {kLength}},
    {"meters", {kLength}},
    {"foot", {kLength, 0, 0.3048}},
    {"feet", {kLength, 0, 0.3048}},
    {"inch", {kLength, 0, 0.0254}},
    {"inches", {kLength, 0, 0.0254}},
    {"micron", {kLength, 0, 1e-6}},
    {"microns", {kLength, 0, 1e-6}},
    {"sec", {kTime}},
    {"secs", {kTime}},
    {"second", {kTime}},
    {"seconds", {kTime}},
    {"minute", {kTime, 0, 60}},
    {"minutes", {kTime, 0, 60}},
    {"hr", {kTime, 0, 3600}},
    {"hour", {kTime, 0, 3600}},
    {"hours", {kTime, 0, 3600}},
    {"day", {kTime, 0, 86400}},
    {"days", {kTime, 0, 86400}},
};

/// That may stand before a word of length or time.
constexpr std::pair<std::string_view, double> kPrefixWords[] = {{"nano", 1e-9},  {"micro", 1e-6},
                                                                {"milli", 1e-3}, {"centi", 1e-2},
                                                                {"deci", 0.1},   {"kilo", 1e3}};

constexpr std::pair<char, double> kPrefixes[] = {{'n', 1e-9}, {'u', 1e-6}, {'m', 1e-3},
                                                 {'c', 1e-2}, {'d', 1e-1}, {'h', 1e2},
                                                 {'k', 1e3},  {'M', 1e6},  {'G', 1e9}};

std::optional<Unit> nameOf(std::string_view name) {
  for (const NamedUnit& one : kUnits) {
    if (name == one.name)
      return one.unit;
    if (name.size() != one.name.size() + 1 || !name.ends_with(one.name) ||
        one.prefixes.find(name.front()) == std::string_view::npos)
      continue;
    Unit unit = one.unit;
    for (const auto& [prefix, factor] : kPrefixes) {
      if (prefix == name.front())
        unit.factor *= factor;
    }
    return unit;
  }
  return std::nullopt;
}

void replaceAll(std::string& text, std::string_view what, std::string_view with) {
  for (std::size_t at = text.find(what); at != text.npos; at = text.find(what, at + with.size()))
    text.replace(at, what.size(), with);
}

/// In the letters of ASCII alone, but for degrees.
std::string plain(std::string_view text) {
  std::string out = asUtf8(trimmedField(text));
  constexpr std::pair<std::string_view, std::string_view> kLetters[] = {
      {"µ", "u"}, {"μ", "u"},      {"²", "2"},    {"³", "3"},   {"⁻", "-"},
      {"¹", "1"}, {"·", "*"},      {"⋅", "*"},    {"**", "^"},  {"−", "-"},
      {"º", "°"}, {"\u00A0", " "}, {"° C", "°C"}, {"° F", "°F"}};
  for (const auto& [letter, with] : kLetters) replaceAll(out, letter, with);
  return out;
}

/// "kW/m2", "mg m^-3", "1/m": names with exponents between / and * or spaces.
std::optional<Unit> productOf(std::string_view text) {
  Unit unit;
  bool divided = false, amount = false, mass = false;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find_first_of("/* "), text.size());
    std::string_view word = text.substr(0, end);
    const std::size_t letters = std::min(word.find_first_of("^-+0123456789", 1), word.size());
    std::string_view power = word.substr(letters);
    if (power.starts_with('^'))
      power.remove_prefix(1);
    int exponent = 1;
    if ((letters < word.size() && !readNumber(power, exponent)) || std::abs(exponent) > 9)
      return std::nullopt;
    const auto name = nameOf(word.substr(0, letters));
    if (!name)
      return std::nullopt;
    amount = amount || name->dimension == kAmount || name->dimension == kVolume ||
             (name->dimension == kLength && exponent == 3);
    mass = mass || name->dimension == kMass;
    exponent = divided ? -exponent : exponent;
    for (std::size_t i = 0; i < unit.dimension.size(); ++i)
      unit.dimension[i] += exponent * name->dimension[i];
    unit.factor *= std::pow(name->factor, exponent);
    if (end == text.size())
      break;
    divided = text[end] == '/';
    text.remove_prefix(end + 1);
    if (text.empty())
      return std::nullopt;
  }
  if (unit.dimension == kNone)
    unit.share = mass ? 'm' : amount ? 'a' : '\0';
  return unit;
}

std::optional<Unit> wordOf(std::string_view lower) {
  const auto* found = std::ranges::find(kWords, lower, &NamedUnit::name);
  return found == std::end(kWords) ? std::nullopt : std::optional(found->unit);
}

std::optional<Unit> unitOf(std::string_view said) {
  const std::string text = plain(said);
  const std::string lower = lowerCase(text);
  if (const auto word = wordOf(lower))
    return word;
  for (const auto& [prefix, factor] : kPrefixWords) {
    auto word = lower.starts_with(prefix) ? wordOf(lower.substr(prefix.size())) : std::nullopt;
    if (word && word->factor == 1 && (word->dimension == kLength || word->dimension == kTime)) {
      word->factor = factor;
      return word;
    }
  }
  const auto unit = productOf(text);
  return unit ? unit : productOf(lower);
}

}  // namespace

std::optional<UnitChange> unitChange(std::string_view from, std::string_view to) {
  const auto a = unitOf(from), b = unitOf(to);
  const bool alike = a && b && a->dimension == b->dimension &&
                     (a->share == b->share || a->share == 0 || b->share == 0);
  if (!alike)
    return std::nullopt;
  return UnitChange{a->factor / b->factor, (a->offset - b->offset) / b->factor};
}

bool isUnit(std::string_view text) {
  return unitOf(text).has_value();
}

}  // namespace volute
