// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <utility>
#include <vector>

#include "volute/medium/any_medium.hpp"

namespace volute {

/// Another medium that takes and sends `factor` times as much light at each point: what scatters
/// light, seen through a transmittance other than e^-depth.
class ScaledMedium {
 public:
  ScaledMedium(AnyMedium medium, double factor) : medium_(std::move(medium)), factor_(factor) {}

  Box3 bounds() const { return medium_.bounds(); }

  double extinction(const Vec3& point) const { return factor_ * medium_.extinction(point); }

  Rgb emission(const Vec3& point) const { return factor_ * medium_.emission(point); }

  void opticalDepth(std::span<const Segment> segments, std::span<double> depths) const {
    medium_.opticalDepth(segments, depths);
    for (double& depth : depths) depth *= factor_;
  }

  void pieces(std::span<const Segment> segments, std::span<std::vector<Piece>> pieces) const {
    medium_.pieces(segments, pieces);
    for (std::vector<Piece>& list : pieces) {
      for (Piece& piece : list) {
        for (double& c : piece.extinction.c) c *= factor_;
        for (Polynomial& channel : piece.emission) {
          for (double& c : channel.c) c *= factor_;
        }
      }
    }
  }

  bool dependsOnEnd() const { return medium_.dependsOnEnd(); }

 private:
  AnyMedium medium_;
  double factor_;
};

/// The medium itself where the factor is 1.
inline AnyMedium scaledBy(double factor, AnyMedium medium) {
  return factor == 1 ? std::move(medium) : AnyMedium(ScaledMedium(std::move(medium), factor));
}

}  // namespace volute
