// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/optics/smoke_potential.hpp"

#include <array>
#include <string>

#include "volute/base/lower_case.hpp"

namespace volute {
namespace {

constexpr std::array<SmokePotential, 11> kTable{{
    {"fibre insulation board", 0.6, 1.8},
    {"chipboard", 0.37, 1.9},
    {"hardboard", 0.35, 1.7},
    {"birch plywood", 0.17, 1.7},
    {"external plywood", 0.18, 1.5},
    {"alpha-cellulose", 0.22, 2.4},
    {"rigid PVC", 1.7, 1.8},
    {"extruded ABS", 3.3, 4.2},
    {"rigid PU foam", 4.2, 1.7},
    {"flexible PU foam", 0.96, 5.1},
    {"plasterboard", 0.042, 0.39},
}};

}  // namespace

Result<Burning> burning(std::string_view name) {
  if (name == "flaming")
    return Burning::kFlaming;
  if (name == "smouldering")
    return Burning::kSmouldering;
  return fail(ErrorCode::kInvalidArgument, "burning '{}': expected flaming or smouldering", name);
}

std::span<const SmokePotential> smokePotentials() {
  return kTable;
}

Result<SmokePotential> smokePotentialOf(std::string_view material) {
  std::string names;
  for (const SmokePotential& entry : kTable) {
    if (lowerCase(entry.material) == lowerCase(material))
      return entry;
    names += (names.empty() ? "" : ", ") + std::string(entry.material);
  }
  return fail(ErrorCode::kNotFound, "no smoke potential for '{}'; known: {}", material, names);
}

}  // namespace volute
