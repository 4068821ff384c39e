// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/synth/hall_case.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "volute/base/write_file.hpp"
#include "volute/fds/fds_writer.hpp"
#include "volute/math/box.hpp"
#include "volute/tetmesh/hall_smoke.hpp"

namespace volute {
namespace {

using fdswriter::Indices;
using fdswriter::Planes;

constexpr double kSootYield = 0.05, kMonoxideYield = 0.04, kDioxideYield = 2, kOxygenTaken = 2.2;
constexpr double kHeat = 25, kShareOfGas = 0.65;      // [kJ/g], 1
constexpr double kAir = 1200, kHeatCapacity = 0.001;  // [g/m3], [kJ/(g K)]
constexpr double kHeatRelease = 1000;                 // [kW], of 1 m2
constexpr double kGrowth = 5;                         // [s]

/// The planes next to both ends of a box, at least a cell apart.
Indices indicesOf(const Planes& planes, const Box3& box) {
  std::array<int, 6> at{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto& p = planes[axis];
    const auto nearest = [&](double place) {
      return static_cast<int>(
          std::ranges::min_element(p, {}, [&](double one) { return std::abs(one - place); }) -
          p.begin());
    };
    const auto a = static_cast<int>(axis);
    at[2 * axis] = nearest(box.min[a]);
    at[2 * axis + 1] = nearest(box.max[a]);
    if (box.min[a] < box.max[a] && at[2 * axis] == at[2 * axis + 1])
      ++(at[2 * axis + 1] < static_cast<int>(p.size()) - 1 ? at[2 * axis + 1] : at[2 * axis]);
  }
  return {at[0], at[1], at[2], at[3], at[4], at[5]};
}

struct Quantity {
  const char *name, *shortName, *unit;
  std::function<double(double soot)> value;
};

}  // namespace

HallAir hallCaseAir(double soot) {
  constexpr double kMolesOfAir = kAir / 28.96;  // [mol/m3]
  const double fuel = soot / kSootYield;        // burnt [g/m3]
  HallAir air;
  air.celsius = 20 + fuel * kHeat * kShareOfGas / (kAir * kHeatCapacity);
  air.monoxide = fuel * kMonoxideYield / 28.01 / kMolesOfAir;
  air.dioxide = 0.0004 + fuel * kDioxideYield / 44.01 / kMolesOfAir;
  air.oxygen = std::max(0.0, 0.209 - fuel * kOxygenTaken / 32 / kMolesOfAir);
  return air;
}

Status writeHallCase(const HallFiles& files, const std::filesystem::path& target,
                     Progress& progress) {
  const Box3 hall{Vec3::Zero(), Vec3(28, 12, 6)};  // as hallMesh()
  // It burns on a stack of goods, so that nobody stands in the column of smoke.
  const Box3 stack{Vec3(22.6, 4.3, 0), Vec3(26.1, 7.7, 2.4)};
  const Box3 seat{Vec3(23.8, 5.5, 2.4), Vec3(24.8, 6.5, 2.4)};
  const std::vector<Box3> walls = {{Vec3(20, 0, 0), Vec3(20.6, 4.8, 6)},
                                   {Vec3(20, 7.2, 0), Vec3(20.6, 12, 6)},
                                   {Vec3(20, 4.8, 2.6), Vec3(20.6, 7.2, 6)},
                                   {Vec3(8, 0, 4.8), Vec3(8.6, 12, 6)},
                                   {Vec3(5, 3, 0), Vec3(5.7, 3.7, 6)},
                                   {Vec3(5, 8.4, 0), Vec3(5.7, 9.1, 6)},
                                   {Vec3(12, 3, 0), Vec3(12.7, 3.7, 6)},
                                   {Vec3(12, 8.4, 0), Vec3(12.7, 9.1, 6)},
                                   stack};
  Planes planes;
  for (int axis = 0; axis < 3; ++axis) {
    const double size = hall.size()[axis];
    const int cells = std::max(4, static_cast<int>(std::lround(size / files.cell)));
    for (int i = 0; i <= cells; ++i)
      planes[static_cast<std::size_t>(axis)].push_back(size * i / cells);
  }
  const std::string name = target.stem().string();
  const std::filesystem::path folder = target.parent_path();
  fdswriter::Index index;
  index.title = "A hall on fire: a formula, not a simulation";
  index.chid = name;
  index.input = name + ".fds";
  index.surfaces = {"BURNER"};
  fdswriter::Index::Mesh mesh{planes, {}, {}, false, {{indicesOf(planes, seat), 1}}, true};
  index.wallColour = "-1   -1";
  for (const Box3& wall : walls) mesh.obstructions.push_back(indicesOf(planes, wall));
  index.meshes = {mesh};
  index.files = fmt::format("ENDF\n {}.end\n\nCSVF\n hrr\n {}_hrr.csv\n\n", name, name);

  std::vector<Vec3> points;
  for (const double z : planes[2]) {
    for (const double y : planes[1]) {
      for (const double x : planes[0]) points.emplace_back(x, y, z);
    }
  }
  const Quantity quantities[] = {
      {"SOOT DENSITY", "rho_soot", "kg/m3", [](double soot) { return soot / 1000; }},
      {"TEMPERATURE", "temp", "C", [](double soot) { return hallCaseAir(soot).celsius; }},
      {"CARBON MONOXIDE VOLUME FRACTION", "X_CO", "mol/mol",
       [](double soot) { return hallCaseAir(soot).monoxide; }},
      {"CARBON DIOXIDE VOLUME FRACTION", "X_CO2", "mol/mol",
       [](double soot) { return hallCaseAir(soot).dioxide; }},
      {"OXYGEN VOLUME FRACTION", "X_O2", "mol/mol",
       [](double soot) { return hallCaseAir(soot).oxygen; }}};
  std::array<std::vector<std::pair<float, std::vector<float>>>, std::size(quantities)> frames;
  std::string heat = "s,kW\nTime,HRR\n";
  for (int i = 0; i < files.steps; ++i) {
    if (progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped before step {}", i);
    const double time = i * files.interval;
    const std::vector<float> soot = hallSmoke(points, time, files.seed);
    for (std::size_t q = 0; q < std::size(quantities); ++q) {
      auto& [when, values] = frames[q].emplace_back(static_cast<float>(time), soot);
      for (float& value : values) value = static_cast<float>(quantities[q].value(value));
    }
    heat += fmt::format("{:g},{:.1f}\n", time, kHeatRelease * (1 - std::exp(-time / kGrowth)));
    progress.report("synthesizing", i + 1, files.steps);
  }
  const auto last = [&](std::size_t axis) { return static_cast<int>(planes[axis].size()) - 1; };
  for (std::size_t q = 0; q < std::size(quantities); ++q) {
    const fdswriter::Slice slice{{0, last(0), 0, last(1), 0, last(2)},
                                 quantities[q].name,
                                 quantities[q].shortName,
                                 quantities[q].unit};
    const std::string file = fmt::format("{}_1_{}.sf", name, q + 1);
    const fdswriter::Records records = fdswriter::sliceFile(slice, frames[q]);
    VOLUTE_TRY(writeFile(folder / file, std::as_bytes(std::span(records.bytes))));
    index.slice(1, slice, file, false);
  }
  VOLUTE_TRY(writeFile(folder / (name + "_hrr.csv"), heat));
  VOLUTE_TRY(
      writeFile(folder / (name + ".fds"),
                fmt::format("&HEAD CHID='{}', TITLE='{}' /\n"
                            "&REAC FUEL='MADE UP', SOOT_YIELD={:g}, CO_YIELD={:g} /\n"
                            "&SURF ID='BURNER', HRRPUA={:g}, COLOR='RED' /\n"
                            "&OBST XB=22.6,26.1,4.3,7.7,0,2.4 /\n"
                            "&VENT SURF_ID='BURNER', XB=23.8,24.8,5.5,6.5,2.4,2.4 /\n&TAIL /\n",
                            name, index.title, kSootYield, kMonoxideYield, kHeatRelease)));
  VOLUTE_TRY(writeFile(folder / (name + ".end"), ""));
  return writeFile(target, index.text());
}

}  // namespace volute
