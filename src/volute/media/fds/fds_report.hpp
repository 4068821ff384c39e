// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>

#include "volute/media/medium_kind.hpp"
#include "volute/report/report.hpp"

namespace volute {

/// What is in a case: meshes, devices, files with their frames, and which source says how thick its
/// smoke is (DescribeRequest::field names another). With `values` the largest extinction [1/m] over
/// all stored times. Errors: of the .smv, and of a source that is named and not there.
[[nodiscard]] Result<Report> describeFdsCase(const std::string& path,
                                             const DescribeRequest& request, Reading& reading);

}  // namespace volute
