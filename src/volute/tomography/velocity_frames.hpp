// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "volute/tomography/reconstructed_frames.hpp"
#include "volute/tomography/volume_flow.hpp"

namespace volute {

/// Velocities [m/s] of reconstructed frames, three channels, from the motion between each frame and
/// the next. Motions are estimated when they are first asked for, and kept in a work folder. They
/// depend on the two frames alone, so the same come out for any number of processes.
class VelocityFrames final : public FrameSource {
 public:
  /// `frames` and `progress` must outlive it. kInvalidArgument for fewer than two frames.
  /// @param output  that of the frames: the work folder is "output.velocity.work", or that of "-"
  [[nodiscard]] static Result<std::unique_ptr<VelocityFrames>> open(
      ReconstructedFrames& frames, const FlowOptions& options, const std::filesystem::path& output,
      Progress& progress);

  const VolumeInfo& info() const override { return info_; }

  [[nodiscard]] Status readFrame(int index, std::span<float> values) override;

  /// Estimates what is missing; a pair of frames is a unit of work. Collective, after
  /// ReconstructedFrames::solveAll().
  [[nodiscard]] Status solveAll(Team& team);

  const WorkFolder& work() const { return work_; }

  /// How fast what is between a frame and the next moves: mean_speed, weighted by its light, and
  /// greatest_speed [m/s].
  [[nodiscard]] Result<nlohmann::ordered_json> record(int pair) const;

  /// The records of all pairs, and the same figures of the whole.
  [[nodiscard]] Result<nlohmann::ordered_json> json() const;

 private:
  VelocityFrames(ReconstructedFrames& frames, const FlowOptions& options, WorkFolder work,
                 Progress& progress)
      : frames_(frames), options_(options), work_(std::move(work)), progress_(progress) {}

  int pairs() const { return info_.frames - 1; }

  [[nodiscard]] Status solve(int pair);
  bool finished(int pair);
  [[nodiscard]] Result<VoxelFlow> flow(int pair);
  double seconds(int pair) const;
  Vec3 perVoxel(int pair) const;

  ReconstructedFrames& frames_;
  FlowOptions options_;
  WorkFolder work_;
  Progress& progress_;
  VolumeInfo info_;
  std::vector<std::string> keys_;  // one a pair
  std::vector<char> finished_;     // known to be
};

}  // namespace volute
