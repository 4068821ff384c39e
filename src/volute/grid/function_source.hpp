// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
#include <span>

#include "volute/grid/frame_source.hpp"

namespace volute {

/// Places at one time: point i is (x[i], y[i], z[i]) [m], at `time` [s].
struct PlacesAtTime {
  std::span<const double> x, y, z;
  double time = 0;
};

/// Values at places: `values` has those of all channels of point 0, then of point 1, and must be
/// filled with finite numbers. An error ends what asked for them. May be asked more than once for
/// the same places, and must give the same values.
using ValueFunction = std::function<Status(const PlacesAtTime& places, std::span<float> values)>;

/// A function of place and time as frames: its values at the centres of voxels, at the times of the
/// frames.
class FunctionSource final : public FrameSource {
 public:
  /// Points that a call asks for, unless the frame, or its layers that are read, have fewer: enough
  /// that a call into another language costs little for each.
  static constexpr std::size_t kBatch = std::size_t{1} << 15;

  /// @param info  validated
  FunctionSource(VolumeInfo info, ValueFunction value)
      : info_(std::move(info)), value_(std::move(value)) {}

  const VolumeInfo& info() const override { return info_; }

  [[nodiscard]] Status readFrame(int index, std::span<float> values) override {
    return readLayers(index, 0, info_.z, values);
  }

  /// Few points at a time are no gain.
  bool readsLayers() const override {
    constexpr int kFewest = 1024;
    return info_.x >= kFewest || info_.x * info_.y >= kFewest;
  }

  /// kInvalidData for values that are not finite.
  [[nodiscard]] Status readLayers(int index, int first, int end, std::span<float> values) override;

 private:
  VolumeInfo info_;
  ValueFunction value_;
};

}  // namespace volute
