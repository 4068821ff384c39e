// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <nlohmann/json.hpp>

#include "volute/cli/reconstruction/reconstructed_frames.hpp"

namespace volute::cli {

/// All that was measured on a reconstruction, for programs: the cameras with the angles between
/// them, each frame with the residual of each camera, hull, saturation, iterations and time, the
/// warnings, and means over the frames.
[[nodiscard]] Result<nlohmann::ordered_json> reconstructionReport(
    const Capture& capture, const ReconstructionSettings& settings,
    const ReconstructedFrames& frames);

/// Names of options for people and programs.
nlohmann::ordered_json settingsJson(const ReconstructionSettings& settings);

}  // namespace volute::cli
