// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>
#include <vector>

#include "volute/cli/reconstruction/reconstructed_frames.hpp"

namespace volute::cli {

/// A digest of all that decides about a reconstruction: the program's version, the options, the
/// cameras, and which pictures of which frames, with their size and time of change.
std::string runKey(const Capture& capture, const ReconstructionSettings& settings,
                   const std::vector<std::string>& heldOut);

}  // namespace volute::cli
