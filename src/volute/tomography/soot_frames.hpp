// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "volute/tomography/pyrometer.hpp"
#include "volute/tomography/reconstructed_frames.hpp"

namespace volute {

/// Temperature [K] and extinction [1/m] of the soot in reconstructed frames, as grids beside their
/// emission; 0 where they are not determined.
class SootFrames {
 public:
  /// `frames` must outlive it, and have ReconstructionSettings::pyrometer; with errorBars there are
  /// grids of standard deviations, too.
  explicit SootFrames(ReconstructedFrames& frames, const CaptureSpectrum& spectrum);

  /// "temperature", "extinction", and with error bars both with "_sigma".
  std::vector<FrameSource*> grids() const;

  /// Mean (weighted by the light) and greatest temperature [K], the largest optical depth at
  /// CaptureSpectrum::kReference along an axis, and how many voxels have a temperature; of all
  /// frames.
  [[nodiscard]] Result<nlohmann::ordered_json> json() const;

 private:
  class Grid;

  ReconstructedFrames& frames_;
  Pyrometer pyrometer_;
  std::vector<std::unique_ptr<FrameSource>> grids_;
};

}  // namespace volute
