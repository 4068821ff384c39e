// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "volute/report/report.hpp"
#include "volute/tomography/capture_refinement.hpp"
#include "volute/tomography/reconstructed_frames.hpp"
#include "volute/tomography/velocity_frames.hpp"

namespace volute {

/// All that was measured on a reconstruction, for programs: the cameras with the angles between
/// them, each frame with the residual of each camera, hull, saturation, iterations and time, the
/// warnings, means over the frames, how the calibration was refined, and velocities unless those
/// are null.
[[nodiscard]] Result<nlohmann::ordered_json> reconstructionReport(
    const CaptureRefinement& refinement, const ReconstructionSettings& settings,
    const ReconstructedFrames& frames, const VelocityFrames* velocity = nullptr);

/// What a file of the volumes leaves of the pictures, `file_residual`, beside what the volumes left
/// before they were compressed; the mean over at most eight frames. A warning, also to `progress`,
/// where the file is clearly worse.
/// @param written  as many frames as `frames`, of the same size
[[nodiscard]] Status addResidualOfFile(ReconstructedFrames& frames, FrameSource& written,
                                       nlohmann::ordered_json& json, Progress& progress);

/// The means of `json`, as reconstructionReport() has them, as rows for people.
void addSummary(const nlohmann::ordered_json& json, Report& report);

/// Names of options for people and programs.
nlohmann::ordered_json settingsJson(const ReconstructionSettings& settings);

}  // namespace volute
