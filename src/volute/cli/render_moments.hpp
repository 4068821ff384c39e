// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>
#include <vector>

#include "volute/cli/render_subject.hpp"

namespace volute::cli {

inline constexpr double kUsualRate = 25;  ///< frames a second

/// The pictures that --time and --frames ask for. A --time past the end of what ends is an error.
/// Frames are those of the first volume, else the steps of the first case of smoke, else of 25 a
/// second.
[[nodiscard]] Result<std::vector<Moment>> momentsOf(const Arguments& arguments,
                                                    const RenderSubject& subject,
                                                    const std::string& target, Progress& progress);

/// From the times of the first and the last picture; films of one picture have the usual rate.
double framesPerSecond(const std::vector<Moment>& moments);

}  // namespace volute::cli
