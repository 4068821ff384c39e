// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>
#include <vector>

#include "volute/cli/reconstruction/reconstructed_frames.hpp"

namespace volute::cli {

/// A digest for each frame of all that decides about its reconstruction: the program's version, the
/// options, the cameras, and size and time of change of its pictures; with a warm start also of all
/// frames before it.
std::vector<std::string> frameKeys(const Capture& capture, const ReconstructionSettings& settings,
                                   const std::vector<std::string>& heldOut);

}  // namespace volute::cli
