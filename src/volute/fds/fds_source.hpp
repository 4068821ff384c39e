// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "volute/fds/smv_index.hpp"
#include "volute/optics/extinction.hpp"

namespace volute {

/// Which files the smoke is read from.
enum class FdsFileKind {
  kSlice,         ///< .sf: floats
  kPlot,          ///< .q: floats, at few times
  kSmoke16,       ///< .s16: 16 bits
  kSmokeDensity,  ///< .s3dd: 8 bits of density (the second generation of .s3d)
  kSmoke,         ///< .s3d: 8 bits of opacity, or of density (third generation)
  kClear,         ///< nothing: there is no smoke
};

/// One file of a source, or one mesh's PLOT3D files.
struct FdsSourcePart {
  int mesh = 0;
  std::size_t entry = 0;  ///< in SmvIndex::slices or smoke, by kind; the first of plots
};

/// One way to know the smoke of a case, or another quantity.
struct FdsSource {
  std::string name;         ///< what options name it by: slice-extinction, s3d
  std::string description;  ///< for people
  FdsFileKind kind = FdsFileKind::kSmoke;
  SmokeQuantity quantity = SmokeQuantity::kExtinction;
  bool cellCentred = false;
  bool volume = false;    ///< fills meshes; else layers one cell thick
  std::string plotted{};  ///< of PLOT3D: the quantity as FDS names it
  std::string species{};  ///< of smoke: whose it is, in FDS's words; that of others adds up to it
  std::vector<FdsSourcePart> parts;
};

/// Which of the five variables of a PLOT3D file a quantity is, the first of that name: each file
/// says so itself, and a restart may write others. Nothing: it has none.
std::optional<std::size_t> plotVariable(const FdsPlotEntry& plot, std::string_view quantity);

/// What a part of a source calls its values; of PLOT3D, the first of its files.
const FdsLabels& labelsOf(const SmvIndex& index, const FdsSource& source,
                          const FdsSourcePart& part);

/// How many meshes it has files of.
int meshesOf(const FdsSource& source);

/// Those that its 3D slices leave a part of out, from 0.
std::set<int> meshesInPart(const SmvIndex& index, const FdsSource& source);

/// All ways that the index offers, best first: extinction as FDS wrote it, optical density, density
/// of soot, visibility (which is capped), then 16-bit, density and opacity bytes; of equal ones
/// those that fill meshes, and of these those of more meshes. PLOT3D, which has few times, is last.
/// Smoke of several species is as many sources, soot's first. Bytes are smoke where they are of
/// soot, or the index gives them a mass extinction. Each has a name of its own.
std::vector<FdsSource> findSources(const SmvIndex& index);

/// Clear air in all meshes, for pictures of a case that stores no smoke.
FdsSource clearSource(const SmvIndex& index);

/// The name of the heat that a fire gives off per volume and time [kW/m3].
inline constexpr std::string_view kFdsHeatRelease = "HRRPUV";

/// The name of the gas temperature [degrees C] of FDS 6.11 that is times the fourth root of its
/// correction of the radiation where it burns (T in K).
inline constexpr std::string_view kFdsTemperature = "TEMPERATURE";
inline constexpr std::string_view kFdsFlameTemperature = "EFFECTIVE FLAME TEMPERATURE";

/// The same for any quantity by the name that FDS gives it, as it is stored. Besides slices and
/// PLOT3D, the heat release and the flames' temperature have bytes (.s3d).
std::vector<FdsSource> findSources(const SmvIndex& index, std::string_view quantity);

}  // namespace volute
