// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>
#include <vector>

#include "volute/tomography/reconstructed_frames.hpp"

namespace volute {

/// A digest for each frame of all that decides about its reconstruction: the program's version, the
/// options, the cameras, and size and time of change of its pictures; with a warm start also of all
/// frames before it in its chain.
std::vector<std::string> frameKeys(const Capture& capture, const ReconstructionSettings& settings,
                                   const std::vector<std::string>& heldOut);

}  // namespace volute
