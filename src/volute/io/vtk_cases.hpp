// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLReader.h>

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/io/mesh.hpp"
#include "volute/io/mesh_walls.hpp"

// Mesh files by VTK's readers; for the VTK plug-in alone, in the child process.

namespace volute {

/// The times of a .vtu file or a case.
[[nodiscard]] Result<std::vector<double>> readVtkTimes(const std::filesystem::path& path);

/// [s], as programs note it in the field data: VTK's (TimeValue) or VisIt (TIME); NaN where it is
/// not stated.
double statedTime(vtkXMLReader& reader);

/// Of a .vtu, or of the first piece of a .pvtu.
[[nodiscard]] Result<MeshHead> readVtkHead(const std::filesystem::path& path);

/// What a file has in one frame.
struct VtkVolume {
  vtkSmartPointer<vtkUnstructuredGrid> grid;  ///< all blocks as one
  double time = 0;                            ///< [s]
  int blocks = 1;                             ///< with volumes
  std::map<std::string, int> partial{};       ///< fields that not all blocks have, and how many do
  std::uint64_t ghosts = 0;                   ///< cells that are marked as such, and left out
  std::vector<WallPolygon> walls{};           ///< of OpenFOAM, with cells on both sides
};

/// Calls fields of points and of cells that have one name "NAME (points)" and "NAME (cells)".
void tellApart(std::vector<MeshFieldSummary>& fields);

/// Fields that not all blocks have, for people.
std::string partialText(const VtkVolume& volume);

/// `field` is what will be taken of it, empty where that is not known yet. `share`: which pieces of
/// a .pvtu; kUnsupported of other files, and where it has fewer pieces than shares.
[[nodiscard]] Result<VtkVolume> readVtkVolume(const std::filesystem::path& path, std::size_t frame,
                                              const std::string& field,
                                              const MeshShare& share = {});

}  // namespace volute
