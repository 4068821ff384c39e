// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/cli/arguments.hpp"
#include "volute/cli/context.hpp"

namespace volute::cli {

/// Whether `reconstruct` takes a file for measured lines: a .csv.
bool isLineFile(const std::string& path);

/// `reconstruct` of measured lines; its targets have been checked.
[[nodiscard]] Status runReconstructLines(const Arguments& arguments, Context& context);

}  // namespace volute::cli
