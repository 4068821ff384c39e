// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <string>

#include "volute/base/result.hpp"
#include "volute/report/report.hpp"

namespace volute {

/// What is in a capture: its cameras, their pictures, the frames and the place of the volume.
/// Damaged where something is missing without which it cannot be reconstructed. Errors: as
/// openCalibration().
/// @param maxMemory  [bytes] for one picture
[[nodiscard]] Result<FileDescription> describeCapture(const std::string& path,
                                                      std::uint64_t maxMemory);

}  // namespace volute
