// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "volute/base/remark.hpp"
#include "volute/base/result.hpp"
#include "volute/math/box.hpp"

// CHID.smv, the text file that names all other files of an FDS case. Meshes, obstructions and
// vents come first, one block for each mesh; files and events follow while the case runs.

namespace volute {

struct FdsInput;

/// From this time on an obstruction or a vent is there, or not.
struct FdsEvent {
  double time = 0;  ///< [s]
  bool shown = true;
};

/// Whether what has these events (ascending) is there at a time [s], the times of the events
/// included. Before the first event it is what that event changes; without events it is there.
bool isShown(std::span<const FdsEvent> events, double time);

/// A box between node indices of its mesh, begin <= end on each axis; two are equal where it is
/// thin.
struct FdsNodeBox {
  std::array<int, 3> begin{};
  std::array<int, 3> end{};

  bool operator==(const FdsNodeBox&) const = default;
};

/// sRGB and opacity, 0..1.
using FdsColour = std::array<float, 4>;

struct FdsObstruction {
  FdsNodeBox nodes;
  std::array<int, 6> surfaces{};  ///< of its faces -x +x -y +y -z +z, places in SmvIndex::surfaces
  std::optional<FdsColour> colour;  ///< else each face has its surface's
  bool drawn = true;                ///< not marked as invisible
  std::vector<FdsEvent> events;     ///< ascending in time

  bool shownAt(double time) const { return isShown(events, time); }
};

struct FdsVent {
  FdsNodeBox nodes;
  int surface = 0;
  std::optional<FdsColour> colour;
  bool open = false;      ///< OPEN or MIRROR: no wall
  bool exterior = false;  ///< added by FDS: the mesh's own wall, where no vent of the input is
  bool drawn = true;      ///< false for OPEN and MIRROR, and for what is marked as invisible
  std::vector<FdsEvent> events;  ///< shown: open
};

struct FdsSurface {
  std::string name;
  FdsColour colour{1.0F, 0.8F, 0.4F, 1.0F};
};

struct FdsMesh {
  std::string name;
  std::array<std::vector<double>, 3> planes;  ///< x, y, z of the nodes [m], strictly ascending
  std::vector<FdsObstruction> obstructions;
  std::vector<FdsVent> vents;

  bool evacuation = false;  ///< people walk on it; there is no gas

  int cells(int axis) const { return static_cast<int>(planes[axis].size()) - 1; }

  std::uint64_t nodeCount() const;
  std::uint64_t cellCount() const;
  Box3 bounds() const;
};

struct FdsDevice {
  std::string label;
  std::string quantity;
  Vec3 position = Vec3::Zero();
  bool active = false;           ///< before the first event
  std::vector<FdsEvent> events;  ///< ascending in time; shown: active

  bool activeAt(double time) const {
    return events.empty() || time < events.front().time ? active : isShown(events, time);
  }
};

/// What a file holds, as the index says it.
struct FdsLabels {
  std::string quantity;
  std::string shortName;
  std::string unit;

  bool operator==(const FdsLabels&) const = default;
};

/// SLCF (values at nodes) or SLCC (values of cells).
struct FdsSliceEntry {
  int mesh = 0;  ///< place in SmvIndex::meshes
  bool cellCentred = false;
  std::optional<FdsNodeBox> nodes;  ///< newer files repeat the slice's own indices
  std::filesystem::path file;
  FdsLabels labels;
};

/// SMOKF3D: 8-bit values at all nodes of a mesh.
struct FdsSmokeEntry {
  int mesh = 0;
  std::optional<double> massExtinction;  ///< [m2/kg]
  std::filesystem::path file;
  FdsLabels labels;
};

/// PL3D: five quantities at all nodes of a mesh at one time.
struct FdsPlotEntry {
  int mesh = 0;
  double time = 0;  ///< [s]
  std::filesystem::path file;
  std::array<FdsLabels, 5> labels;
};

/// ISOG, TISOG: triangles on which a quantity has given values.
struct FdsIsoEntry {
  int mesh = 0;
  std::filesystem::path file;
  FdsLabels labels;
};

/// CLASS_OF_PARTICLES.
struct FdsParticleClass {
  std::string name;
  std::array<float, 3> colour{};  ///< sRGB, 0..1
};

/// PRT5: where the particles of a mesh are.
struct FdsParticleEntry {
  int mesh = 0;
  std::vector<int> classes;  ///< places in SmvIndex::particleClasses, in the file's order
  std::filesystem::path file;
};

/// People of FDS+Evac, on a mesh that is left out.
struct FdsPeopleEntry {
  std::string mesh;
  std::filesystem::path file;
};

/// Any other file that the index names: boundary files, tables.
struct FdsOtherFile {
  std::string kind;  ///< for people
  int mesh = -1;     ///< place in SmvIndex::meshes; -1: of the whole case
  std::filesystem::path file;
};

struct SmvIndex {
  std::filesystem::path path;
  std::string version;  ///< FDSVERSION's first line
  std::string title;
  std::string chid;
  std::shared_ptr<const FdsInput> input;  ///< INPF, if it is there and of this case: inputOf()
  double albedo = 0.3;                    ///< what Smokeview gives soot
  std::optional<double> fireCutoff;  ///< HRRPUVCUT [kW/m3]: less heat than this is drawn as no fire
  std::optional<double> largestHeat;  ///< HRRPUV_MINMAX [kW/m3], FDS 6.11: what the last byte is
  /// TEMP_MINMAX [degrees C], FDS 6.11: what bytes 0 and 254 of temperature are.
  std::optional<std::array<double, 2>> temperatureRange;
  std::optional<double>
      north;  ///< NORTHANGLE [degrees], -180..180: from +y clockwise, seen from above
  std::vector<FdsMesh> meshes;  ///< of gas: meshes of FDS+Evac are left out
  std::vector<FdsSurface> surfaces;
  std::vector<FdsDevice> devices;
  std::vector<FdsSliceEntry> slices;
  std::vector<FdsSmokeEntry> smoke;
  std::vector<FdsPlotEntry> plots;
  std::vector<FdsIsoEntry> isosurfaces;
  std::vector<FdsParticleClass> particleClasses;
  std::vector<FdsParticleEntry> particles;
  std::vector<FdsPeopleEntry> people;
  std::vector<FdsOtherFile> others;
  bool ended = false;           ///< FDS has written its .end file
  std::vector<Remark> remarks;  ///< what was left out and why

  /// kTruncated when the file ends within the meshes; what is cut off later is left out with a
  /// remark. All errors name the line. kTooLarge for more obstructions and vents than `maxMemory`
  /// holds with what is made of them.
  [[nodiscard]] static Result<SmvIndex> read(
      const std::filesystem::path& path,
      std::uint64_t maxMemory = std::numeric_limits<std::uint64_t>::max());
};

/// By the name's end: .smv.
bool isSmvPath(const std::string& path);

}  // namespace volute
