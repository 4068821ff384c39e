// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/fog/polar_table.hpp"

namespace volute {

/// Fog for pictures from one eye: segments that begin at the eye are looked up in a PolarTable,
/// within kPolarError, all others and those it does not serve are walked. Depths and pieces are the
/// fog's own, exact.
///
/// A Medium and FastMedium.
class PolarFog {
 public:
  /// As PolarTable::make, whose kUnsupported means that the fog itself is the medium to use.
  [[nodiscard]] static Result<PolarFog> make(const FogMedium& fog, const Vec3& eye,
                                             const PolarOptions& options = {});

  Box3 bounds() const { return fog_.bounds(); }

  double extinction(const Vec3& point) const { return fog_.extinction(point); }

  Rgb emission(const Vec3& point) const { return fog_.emission(point); }

  void opticalDepth(std::span<const Segment> segments, std::span<double> depths) const {
    fog_.opticalDepth(segments, depths);
  }

  void pieces(std::span<const Segment> segments, std::span<std::vector<Piece>> pieces) const {
    fog_.pieces(segments, pieces);
  }

  void radiance(std::span<const Segment> segments, std::span<Radiance> out) const;

  bool dependsOnEnd() const { return fog_.dependsOnEnd(); }

  const PolarTable& table() const { return table_; }

 private:
  PolarFog(FogMedium fog, const Vec3& eye, PolarTable table)
      : fog_(std::move(fog)), eye_(eye), table_(std::move(table)) {}

  FogMedium fog_;
  Vec3 eye_;
  PolarTable table_;
};

}  // namespace volute
