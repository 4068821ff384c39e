// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>

#include "volute/cli/context.hpp"

namespace volute::cli {

/// checkOutput(), and its folder is watched for half-written files.
[[nodiscard]] Status checkTarget(const std::string& target, bool standardOutput = false);

/// As above, of what may also go to standard output, which --json wants too; with "-" results are
/// shown on standard error.
[[nodiscard]] Status checkTarget(const std::string& target, Context& context);

}  // namespace volute::cli
