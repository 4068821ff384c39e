// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "volute/capture/open_capture.hpp"
#include "volute/grid/sequence.hpp"
#include "volute/tomography/line_reconstruction.hpp"

namespace volute {

/// Volumes of all times of a file of lines.
struct LineVolumes {
  /// "extinction" [1/m] of optical depths and transmittances, else "density". Frames without times
  /// are 25 a second.
  Sequence volumes;
  /// Of each frame: frame, lines, lambda, iterations, residual, left_out, spread, crossed_share, as
  /// LineReconstruction has them; null where it has none.
  nlohmann::ordered_json records = nlohmann::ordered_json::array();

  /// Mean of a figure over the records.
  double mean(const char* figure) const;
};

/// Reconstructs the frames of lines one by one. Without bounds the
/// volume is the box around the lines' ends, which a remark states; without a resolution it has 32
/// voxels on its longest side.
/// @param name   in errors and remarks
/// @param where  its bounds, resolution, frames and maxMemory count, the latter for all values
/// @param leaveOut  leave out lines that miss the volume, with a remark, instead of refusing them
/// Errors: those of reconstructLines(), with name and frame; kInvalidArgument where the lines do
/// not tell where the volume is, or no frame is selected; kTooLarge.
[[nodiscard]] Result<LineVolumes> reconstructLineFrames(LineFile lines, const std::string& name,
                                                        const CaptureOptions& where,
                                                        const LineOptions& how, bool leaveOut,
                                                        Progress& progress);

/// Reconstructs a file of lines, as readLines() reads it.
[[nodiscard]] Result<LineVolumes> reconstructLineFile(const std::string& file,
                                                      const CaptureOptions& where,
                                                      const LineOptions& how, bool leaveOut,
                                                      Progress& progress);

}  // namespace volute
