// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "volute/visibility/floor_plan.hpp"

namespace volute {

/// A quantity over a plan, shape (y, x).
struct PlanArray {
  std::string name;
  std::vector<float> values;
};

/// Writes a plan as VTK image data, one cell for each point, all arrays in one .vti file.
[[nodiscard]] Status writePlanVti(const std::filesystem::path& path, const FloorPlan& plan,
                                  const std::vector<PlanArray>& arrays);

/// Writes a table: x, y, z of each point [m] where `places` has gas, and a column for each array;
/// empty where nothing is known, inf where an array is.
[[nodiscard]] Status writePlanCsv(const std::filesystem::path& path, const FloorPlan& plan,
                                  const std::vector<PlanArray>& arrays);

/// Writes a .pvd: files beside it, with their times [s].
[[nodiscard]] Status writePvd(const std::filesystem::path& path,
                              const std::vector<std::pair<double, std::string>>& files);

}  // namespace volute
