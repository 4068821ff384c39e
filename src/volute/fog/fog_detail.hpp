// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>

namespace volute {

constexpr int kMaxFogLevels = 10;

/// Which level of a fog map is integrated at what distance from the eye, which is the origin of the
/// segment (s = 0). What is integrated at each distance is the merged approximation of one level:
/// the same as the paper's sum over nested bands of details that end at their distances, in one
/// walk (docs/papers.md).
struct FogDetail {
  /// Giroud and Biri 2010, equation 12: level L ends at mu^(J - L) |OP|, from the finest L = 0 to
  /// the coarsest L = J; 0^0 = 1. 1: the finest everywhere. 0: the coarsest everywhere. P is the
  /// end of the segment, or where it leaves the map for an infinite one, so what lies behind the
  /// fog changes its detail.
  double mu = 1;

  /// When > 0, instead of mu: level L from the distance on at which its cells are seen under this
  /// angle [rad]; k pixels' worth of it is the finest detail a picture shows. Depends on the
  /// distance alone.
  double cellAngle = 0;

  /// True when level 0 is used at every distance.
  bool finestOnly() const { return cellAngle <= 0 && mu >= 1; }

  /// True when the end of a segment decides.
  bool dependsOnEnd() const { return cellAngle <= 0 && mu > 0 && mu < 1; }

  using Ends = std::array<double, kMaxFogLevels + 1>;

  /// ends[L] is the distance at which level L ends, ascending; the last is infinite.
  /// @param cell  [m], of level 0
  /// @param distance  |OP| [m]; may be infinite
  Ends ends(int levels, double cell, double distance) const;
};

}  // namespace volute
