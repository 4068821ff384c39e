// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "volute/io/vtk_cases.hpp"

namespace volute {

/// The values by which an Exodus file says that a field has none there (netCDF's attributes
/// _FillValue and missing_value), by the field's name; VTK's reader takes no notice of them.
[[nodiscard]] std::map<std::string, std::vector<double>> exodusFills(
    const std::filesystem::path& path);

/// Puts netCDF's own fill value in their place, in the scalars of a grid.
void settleFills(const std::map<std::string, std::vector<double>>& fills,
                 vtkUnstructuredGrid& grid);

}  // namespace volute
