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

  /// As "soot" of a report: mean (weighted by the light) and greatest temperature [K], the largest
  /// optical depth at CaptureSpectrum::kReference along an axis, and how many voxels have a
  /// temperature; of all frames. What is doubtful is a warning of it, and remarked.
  [[nodiscard]] Status addTo(nlohmann::ordered_json& report, Progress& progress) const;

 private:
  class Grid;

  ReconstructedFrames& frames_;
  Pyrometer pyrometer_;
  std::vector<std::unique_ptr<FrameSource>> grids_;
};

/// What the soot of all frames is like, and whether it can be.
class SootSummary {
 public:
  /// `pyrometer` must outlive it.
  explicit SootSummary(const Pyrometer& pyrometer) : pyrometer_(pyrometer) {}

  /// A frame.
  void add(const VolumeGeometry& geometry, std::span<const float> emission);

  /// Where no temperature explains most of the light, channels contradict one another, or there is
  /// more or less soot than pictures can show: a spectrum that is not that of the pictures.
  [[nodiscard]] std::vector<std::string> doubts() const;

  /// See SootFrames::addTo().
  [[nodiscard]] nlohmann::ordered_json json() const;

 private:
  static constexpr double kUsual = 1800;  ///< [K] of flames

  const Pyrometer& pyrometer_;
  Rgb light_ = Rgb::Zero();
  double known_ = 0, weighted_ = 0, greatest_ = 0, deepest_ = 0;
  std::int64_t voxels_ = 0;
};

}  // namespace volute
