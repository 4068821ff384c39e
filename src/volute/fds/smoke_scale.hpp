// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/optics/extinction.hpp"

namespace volute {

/// Extinction [1/m] and what it may be at least and at most.
struct SmokeBand {
  float value = 0;
  float low = 0;
  float high = 0;
};

/// How stored values become extinction.
///
/// A byte b of opacity (FDS until 2025) is NINT(254 (1 - exp(-Km dx rho))), dx the first cell on x
/// of its own mesh: K = -ln(1 - b / 254) / dx, and b = 254 says K >= ln(508) / dx and no more. A
/// byte of density (later) is rho = largest b / 254, rounded in a way that is not documented: up to
/// a whole step is allowed for. Both are means over the eight cells round a node in which
/// obstructions and what lies across the mesh's edges count as 0; dividing by the share of gas
/// among them gives the mean of the gas.
struct SmokeScale {
  enum class Bytes { kNone, kOpacity, kDensity };

  SmokeQuantity quantity = SmokeQuantity::kExtinction;  ///< of physical values
  double massExtinction = kFdsMassExtinction;           ///< [m2/kg]
  double visibilityFactor = 3;
  double visibilityCap = 30;  ///< [m]
  Bytes bytes = Bytes::kNone;
  double cellLength = 0;      ///< [m], of opacity
  double largestDensity = 0;  ///< [kg/m3], of b = 254
  double step = 0;            ///< of physical values that were rounded

  /// Whether values stand for a range.
  bool inexact() const {
    return bytes != Bytes::kNone || step > 0 || quantity == SmokeQuantity::kVisibility;
  }

  /// Of a stored value; `gas` of the eight cells round its node count. The value is NaN where that
  /// makes no sense.
  SmokeBand band(float stored, int gas) const;
};

}  // namespace volute
