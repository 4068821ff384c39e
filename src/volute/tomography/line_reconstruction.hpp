// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "volute/base/progress.hpp"
#include "volute/tomography/line_file.hpp"
#include "volute/tomography/reconstruct.hpp"
#include "volute/tomography/view.hpp"

namespace volute {

struct LineOptions {
  Basis basis = Basis::kBox;     ///< kTrilinear fades out at the volume's faces, as walls do not
  std::optional<double> lambda;  ///< strength of the smoothness, times the largest eigenvalue of
                                 ///< S'S; none: what predicts lines best that are left out in turn
  std::optional<int> iterations;
  std::uint64_t maxMemory = std::uint64_t{4} << 30;  ///< [bytes]
};

/// A volume from lines.
struct LineReconstruction {
  std::vector<float> volume;  ///< (z, y, x), integrand of the lines' values
  double lambda = 0;          ///< used
  int iterations = 0;         ///< of the last fit
  double residual = 0;        ///< relative L2 of what the lines have
  double leftOut = 0;         ///< the same of lines that were left out in turn; 0: none were
  double spread = 0;   ///< root mean square of residual / sigma; about 1 where sigmas are right
  double crossed = 0;  ///< share of the voxels that a line passes
};

/// Positions of the lines that do not meet the volume.
std::vector<std::size_t> linesBeside(std::span<const LineMeasurement> lines,
                                     const VolumeGeometry& geometry);

/// min 1/2 |W (S a - values)|^2 + lambda / 2 |gradient of a|^2, a >= 0, over all voxels, by the
/// projector that cameras have; W is 1 / sigma. Differences across the volume's faces cost nothing.
/// The strength is chosen by leaving out a fifth of the lines in turn. The same result for any
/// number of threads.
/// Errors: kInvalidArgument for fewer than two lines, lines beside the volume, or a geometry that
/// makes no sense, kTooLarge, kCancelled.
[[nodiscard]] Result<LineReconstruction> reconstructLines(std::span<const LineMeasurement> lines,
                                                          const VolumeGeometry& geometry,
                                                          const LineOptions& options,
                                                          Progress& progress);

}  // namespace volute
