// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <memory>

#include "volute/base/progress.hpp"
#include "volute/grid/sequence.hpp"

namespace volute {

/// What to synthesize: a turbulent flame (fast, about nine tenths of the voxels exactly 0) or three
/// mixing columns of coloured smoke (slow, fills more of the volume).
enum class SynthKind { kFire, kSmoke };

/// The cube of 2 m side with z up: x and y from -1 to 1, z from 0 to 2; 25 frames a second.
/// Values are linear RGB (channels 3), or one number a voxel (channels 1):
///   fire   emission [radiance/m], or `flame`, its luminance
///   smoke  density, meant as extinction [1/m], for each colour or of all smoke
struct SynthOptions {
  SynthKind kind = SynthKind::kFire;
  int size = 64;           ///< voxels on a side, 16..128 and a multiple of 8
  int frames = 64;         ///< 1..100000
  std::uint32_t seed = 1;  ///< another seed gives another fire
  int channels = 3;        ///< 1 or 3
};

/// A synthetic sequence that is computed while it is read. The same options give the same bytes on
/// every machine and for any number of threads. The first frame shows a developed flame or plume.
/// Read frames in order; reading an earlier one restarts from the beginning.
class SyntheticSource final : public FrameSource {
 public:
  /// kInvalidArgument if the options are out of range. `progress` is polled and updated between
  /// frames and must outlive the source.
  [[nodiscard]] static Result<std::unique_ptr<SyntheticSource>> create(const SynthOptions& options,
                                                                       Progress& progress);
  ~SyntheticSource() override;

  const VolumeInfo& info() const override { return info_; }

  /// kCancelled if `progress` requests it; it may be called again.
  [[nodiscard]] Status readFrame(int index, std::span<float> values) override;

 private:
  struct State;
  SyntheticSource(const SynthOptions& options, Progress& progress);

  SynthOptions options_;
  VolumeInfo info_;
  Progress& progress_;
  std::unique_ptr<State> state_;
};

/// All frames at once; kTooLarge when they need more than `maxBytes`.
[[nodiscard]] Result<Sequence> synthesize(const SynthOptions& options, Progress& progress,
                                          std::uint64_t maxBytes = std::uint64_t{4} << 30);

}  // namespace volute
