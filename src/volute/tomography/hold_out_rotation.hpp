// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "volute/tomography/capture_refinement.hpp"
#include "volute/tomography/reconstructed_frames.hpp"

namespace volute {

/// How the others predict a camera that was left out, the mean over the frames.
struct LeftOutCamera {
  std::string name;
  double psnr = 0;      ///< [dB], as ViewResidual has it
  double residual = 0;  ///< relative L2
};

/// A capture reconstructed once without each of its cameras in turn: how well the cameras predict
/// one another.
class HoldOutRotation {
 public:
  /// Reconstructs; the work folders beside `output` are removed with the object. `capture` must
  /// outlive it. Each time, the calibration is refined anew without the camera that is left out.
  [[nodiscard]] static Result<std::unique_ptr<HoldOutRotation>> run(
      const Capture& capture, const ReconstructionSettings& settings, Refine refine,
      const std::filesystem::path& output, std::uint64_t maxMemory, Progress& progress);

  ~HoldOutRotation();
  HoldOutRotation(const HoldOutRotation&) = delete;
  HoldOutRotation& operator=(const HoldOutRotation&) = delete;

  /// One a camera, in the order of the capture.
  const std::vector<LeftOutCamera>& cameras() const { return cameras_; }

  /// The mean over the cameras [dB].
  double psnr() const;

  nlohmann::ordered_json json() const;

  /// Adds held_out_psnr, held_out_in_turn and the verdict on the capture to what
  /// reconstructionReport() has.
  void addTo(nlohmann::ordered_json& json, const Capture& capture) const;

 private:
  struct Run;

  HoldOutRotation() = default;

  std::vector<std::unique_ptr<Run>> runs_;
  std::vector<LeftOutCamera> cameras_;
};

/// One sentence on a reconstruction: how near new views come, what limits that, and what would
/// improve it most.
/// @param fitted  relative L2 of the fitted cameras with all of them.
std::string captureVerdict(const Capture& capture, std::span<const LeftOutCamera> cameras,
                           double fitted);

}  // namespace volute
