// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>

#include "volute/base/result.hpp"
#include "volute/media/medium_kind.hpp"
#include "volute/report/report.hpp"

namespace volute {

/// What is in a volume of any format: size, frames, times [s], bounds [m], grids of an OpenVDB
/// file; of a .volute also which error was asked for and reached, and whether every byte is intact.
/// With `values` the range over all frames, with `blocks` a line for each block of a .volute. A
/// damaged .volute is described as far as it is intact. Errors: as openVolume().
[[nodiscard]] Result<FileDescription> describeVolume(const std::string& path,
                                                     const DescribeRequest& request,
                                                     Reading& reading);

}  // namespace volute
