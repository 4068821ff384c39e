// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>

#include "volute/cli/context.hpp"
#include "volute/fds/fds_case.hpp"

namespace volute::cli {

/// What is in a case, and which source says how thick its smoke is. With `values` the extremes of
/// the extinction over all stored times.
[[nodiscard]] Result<Report> describeFdsCase(const std::string& path, const std::string& source,
                                             bool values, Context& context);

}  // namespace volute::cli
