// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

#include "volute/tomography/reconstructed_frames.hpp"

namespace volute {

/// Writes the report as one HTML page without parts elsewhere: the figures, residuals over the
/// frames, and pictures of a few frames side by side, given, projected, and their difference.
[[nodiscard]] Status writeReconstructionPage(const std::filesystem::path& target,
                                             const nlohmann::ordered_json& report,
                                             ReconstructedFrames& frames, Progress& progress);

}  // namespace volute
