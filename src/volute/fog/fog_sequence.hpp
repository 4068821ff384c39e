// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <vector>

#include "volute/fog/fog_medium.hpp"

namespace volute {

/// Fog that changes: maps at given times, linear between them, the first before and the last after;
/// blown by a constant wind. All levels are mixed, which is the same as the levels of the mixed
/// map.
class FogSequence {
 public:
  struct Frame {
    double time = 0;  ///< [s]
    FogMap map;
  };

  /// @param wind  [m/s], from time 0 on
  /// kInvalidArgument when there is no frame, times do not rise, or maps differ in size or place.
  [[nodiscard]] static Result<FogSequence> make(std::vector<Frame> frames,
                                                const FogProfile& profile,
                                                const FogOptions& options = {},
                                                const Vec3& wind = Vec3::Zero());

  /// The fog at one time [s].
  FogMedium at(double time) const;

  /// The same maps under another profile.
  FogSequence withProfile(const FogProfile& profile) const;

 private:
  FogSequence() = default;

  std::vector<double> times_;
  std::vector<FogMedium> fogs_;
  Vec3 wind_ = Vec3::Zero();
};

}  // namespace volute
