// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "volute/base/result.hpp"

namespace volute {

/// Whether the files of an EnSight Gold case that hold the geometry and a scalar field at a time
/// [s] are whole, in ASCII or C binary: each ends where the counts in it say, lines have numbers,
/// and the field has values for every part with volumes, of no other parts. VTK's reader repeats
/// the last value, or leaves parts out, where the end is missing, and takes what is no number for
/// 0. Other EnSight formats, and parts on structured grids, are not looked at.
[[nodiscard]] Status checkEnsight(const std::filesystem::path& casePath, const std::string& field,
                                  double time);

/// When a scalar of an EnSight Gold case is stored [s], by its own time set; of an empty name, of
/// the only scalar or the one called "density". Nothing where the case has one time set for all, or
/// does not say. VTK shows the values of each time set at the times of all.
[[nodiscard]] std::optional<std::vector<double>> ensightTimes(const std::filesystem::path& casePath,
                                                              const std::string& field);

/// Whether the times in a case's own file are as many as it says, and ascend.
[[nodiscard]] Status checkEnsightCase(const std::filesystem::path& casePath);

}  // namespace volute
