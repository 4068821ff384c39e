// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <vector>

#include "volute/capture/open_capture.hpp"
#include "volute/cli/arguments.hpp"
#include "volute/cli/context.hpp"
#include "volute/cli/option.hpp"

namespace volute::cli {

/// --images, --bounds, --resolution, --color: what a calibration may leave open. Commands add them
/// to their own options.
std::vector<Option> captureOptionTable();

/// The same as the library takes them; --frames too, where the command has it.
[[nodiscard]] Result<CaptureOptions> captureOptionsOf(const Arguments& arguments,
                                                      const Context& context);

}  // namespace volute::cli
