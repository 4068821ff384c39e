// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>

#include "volute/base/result.hpp"
#include "volute/io/reading.hpp"
#include "volute/report/report.hpp"

namespace volute {

/// What is in a case of smoke on a mesh: its frames, its cells and what becomes of them, its
/// fields with their ranges in the first frame, or with `values` over all. Errors: of a file that
/// cannot be read at all.
[[nodiscard]] Result<FileDescription> describeMeshCase(const std::string& path, bool values,
                                                       Reading& reading);

}  // namespace volute
