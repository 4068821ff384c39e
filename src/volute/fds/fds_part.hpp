// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <limits>

#include "volute/fds/fds_case.hpp"

// Inside of FdsCase.

namespace volute {

/// How far meshes may be apart that FDS connects [m] (MESH_SEPARATION_DISTANCE in its read.f90): no
/// more than kMeshSeparation, and than a twentieth of the smallest cell of all, by the cube root of
/// its volume.
double meshSeparation(std::span<const FdsLattice> lattices);

/// The same for the planes of one, which must not be moved past each other [m].
double meshSeparation(const FdsLattice& lattice, int axis, double separation);

/// How the values of a lattice lie in its file.
struct FdsFileAxes {
  std::array<std::vector<int>, 3> place;  // of each lattice value, on each axis
  std::array<int, 3> size{};              // of the file's box
};

/// One file, and the lattice that its values are on.
struct FdsCase::Part {
  FdsSourcePart what;
  std::filesystem::path path;
  std::unique_ptr<FdsFrameFile> file;
  FdsLattice lattice;
  FdsFileAxes axes;
  std::array<std::vector<std::array<int, 2>>, 3> meshCells;  // of each lattice cell
  double massExtinction = kFdsMassExtinction;
  bool assumesExtinction = false;    // nobody states it
  double cellLength = 0;             // dx of the opacity of .s3d [m]
  std::vector<FdsSizeRow> sizeRows;  // of .s3d
  static constexpr std::size_t kNoFrame = std::numeric_limits<std::size_t>::max();
  std::vector<std::size_t> frameAt;  // of the file, for each of the case's times, or kNoFrame

  /// What stays while no obstruction or vent comes or goes.
  struct Geometry {
    std::size_t changes = 0;  // FdsCase::changesUntil() the time that it is of
    std::vector<std::uint8_t> needed;
    std::vector<NodeCells> round;  // of smoke that is averaged; else empty
  };

  std::shared_ptr<const Geometry> geometry;  // of the last time
  std::optional<bool> beginsClear;           // whether the first frame has no smoke

  using Cells = std::pair<std::size_t, std::shared_ptr<const std::vector<FdsCell>>>;
  Cells cells;         // by their changes
  Cells unknownCells;  // the same while there is no frame
  std::shared_ptr<const FdsValues> unknownValues;

  bool hasFrame(std::size_t position) const { return frameAt[position] != kNoFrame; }

  /// The lattice cell's state where `solid` are the mesh's cells: solid when all it spans are.
  bool isSolid(const FdsMesh& mesh, std::span<const std::uint8_t> solid,
               const std::array<int, 3>& cell) const {
    const auto& [x0, x1] = meshCells[0][static_cast<std::size_t>(cell[0])];
    const auto& [y0, y1] = meshCells[1][static_cast<std::size_t>(cell[1])];
    const auto& [z0, z1] = meshCells[2][static_cast<std::size_t>(cell[2])];
    for (int z = z0; z <= z1; ++z) {
      for (int y = y0; y <= y1; ++y) {
        for (int x = x0; x <= x1; ++x) {
          if (solid[(static_cast<std::size_t>(z) * mesh.cells(1) + y) * mesh.cells(0) + x] == 0)
            return false;
        }
      }
    }
    return true;
  }

  /// Calls body(cell) for each cell of the lattice, x fastest.
  template <class Body>
  void forCells(Body&& body) const {
    for (int z = 0; z < lattice.cells(2); ++z) {
      for (int y = 0; y < lattice.cells(1); ++y) {
        for (int x = 0; x < lattice.cells(0); ++x) body(std::array<int, 3>{x, y, z});
      }
    }
  }

  /// Whether none of the values that the cell needs is missing.
  bool hasValues(std::span<const float> values, const std::array<int, 3>& cell) const {
    if (!lattice.nodal)
      return !std::isnan(values[lattice.cellAt(cell)]);
    const NodePlaces places(lattice);
    for (int corner = 0; corner < 8; ++corner) {
      if (std::isnan(values[places.first(cell) + places.offset(corner)]))
        return false;
    }
    return true;
  }

  /// 1 for each value that a cell of gas needs.
  std::vector<std::uint8_t> needed(const FdsMesh& mesh, std::span<const std::uint8_t> solid) const {
    std::vector<std::uint8_t> needed(lattice.valueCount(), 0);
    const NodePlaces places(lattice);
    forCells([&](const std::array<int, 3>& cell) {
      if (isSolid(mesh, solid, cell))
        return;
      if (!lattice.nodal) {
        needed[lattice.cellAt(cell)] = 1;
        return;
      }
      for (int corner = 0; corner < 8; ++corner)
        needed[places.first(cell) + places.offset(corner)] = 1;
    });
    return needed;
  }
};

}  // namespace volute
