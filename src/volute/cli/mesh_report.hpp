// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>

#include "volute/base/result.hpp"
#include "volute/cli/context.hpp"
#include "volute/cli/report.hpp"

namespace volute::cli {

/// What is in a case of smoke on a mesh: its instants, its cells and what becomes of them, its
/// fields with their ranges at the first instant, or with `values` over all. `damaged` becomes true
/// when something of it cannot be used; the report says what.
[[nodiscard]] Result<Report> describeMeshCase(const std::string& path, bool values,
                                              Context& context, bool& damaged);

}  // namespace volute::cli
