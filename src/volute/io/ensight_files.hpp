// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <string>

#include "volute/base/result.hpp"

namespace volute {

/// Whether the files of an EnSight Gold case that hold the geometry and a scalar field at a time
/// [s] are whole, in ASCII or C binary: each ends where the counts in it say, lines have numbers,
/// and the field has values for every part with volumes, of no other parts. VTK's reader repeats
/// the last value, or leaves parts out, where the end is missing, and takes what is no number for
/// 0. Other EnSight formats, and parts on structured grids, are not looked at.
[[nodiscard]] Status checkEnsight(const std::filesystem::path& casePath, const std::string& field,
                                  double time);

/// Whether the times in a case's own file are as many as it says, and ascend.
[[nodiscard]] Status checkEnsightCase(const std::filesystem::path& casePath);

}  // namespace volute
