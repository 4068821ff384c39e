// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>

#include "volute/base/result.hpp"
#include "volute/cli/context.hpp"
#include "volute/cli/report.hpp"

namespace volute::cli {

/// What is in a scene: its media with sizes, times and bounds, its surfaces, lights, signs, camera.
[[nodiscard]] Result<Report> describeScene(const std::string& path, Context& context);

/// What is in a capture: its cameras, their pictures, the frames and the place of the volume.
/// `damaged` becomes true when something is missing without which it cannot be reconstructed; the
/// report says what.
[[nodiscard]] Result<Report> describeCapture(const std::string& path, Context& context,
                                             bool& damaged);

}  // namespace volute::cli
