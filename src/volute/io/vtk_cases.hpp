// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>

#include <filesystem>
#include <string>
#include <vector>

#include "volute/base/result.hpp"

// Mesh files by VTK's readers; for the VTK plug-in alone, in the child process.

namespace volute {

/// The instants of a .vtu file or a case.
[[nodiscard]] Result<std::vector<double>> readVtkTimes(const std::filesystem::path& path);

/// What a file has at one instant.
struct VtkVolume {
  vtkSmartPointer<vtkUnstructuredGrid> grid;  ///< all blocks with volumes as one
  vtkSmartPointer<vtkDataObject> whole;       ///< as VTK read it
};

[[nodiscard]] Result<VtkVolume> readVtkVolume(const std::filesystem::path& path,
                                              std::size_t instant);

/// What VTK does not see: the end missing from an EnSight field in ASCII.
[[nodiscard]] Status checkVtkCase(const std::filesystem::path& path, const std::string& field,
                                  vtkDataObject* whole);

}  // namespace volute
