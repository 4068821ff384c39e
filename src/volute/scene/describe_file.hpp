// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>

#include "volute/base/result.hpp"
#include "volute/media/medium_kind.hpp"
#include "volute/report/report.hpp"

namespace volute {

/// What is in a file, for people and programs: a scene's media with sizes, times and bounds, its
/// surfaces, lights, signs and camera; a picture's size and range; of a medium the description by
/// its kind (MediumKind::describe). Errors: of a file that cannot be read at all.
[[nodiscard]] Result<FileDescription> describeFile(const std::string& path,
                                                   const DescribeRequest& request,
                                                   Reading& reading);

}  // namespace volute
