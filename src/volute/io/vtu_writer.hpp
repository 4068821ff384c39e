// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "volute/base/result.hpp"
#include "volute/tetmesh/tet_mesh.hpp"

namespace volute {

/// Writes tets and one float for each vertex as a .vtu file (VTK XML, appended raw data).
[[nodiscard]] Status writeVtu(const std::filesystem::path& path, const TetMesh& mesh,
                              const std::string& field, std::span<const float> values);

/// A file of a series, and its time [s].
struct SeriesFile {
  std::string name;  ///< from the collection's folder
  double time = 0;
};

/// Writes a .pvd collection.
[[nodiscard]] Status writePvd(const std::filesystem::path& path, std::span<const SeriesFile> files);

}  // namespace volute
