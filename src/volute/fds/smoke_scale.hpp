// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>

#include "volute/fds/solids.hpp"
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
/// A byte b of opacity (FDS until 2025) stands for e = 254 (1 - exp(-K dx)), dx the first cell on x
/// of its own mesh, cut off to b (6.5) or rounded (6.7): K = -ln(1 - e / 254) / dx, and the last
/// byte says "at least" and no more. A byte of density (later) is rho = largest b / 254, rounded in
/// a way that is not documented: up to a whole step is allowed for.
///
/// A byte of heat release (all versions) is 254 q / HRRPUV_MAX_SMV, cut off; the last one says "at
/// least". A byte of temperature (6.11) is 254 (T - least) / (largest - least), cut off, with
/// TEMP_MIN_SMV and TEMP_MAX_SMV; the first says "at most", the last "at least".
///
/// All of them are means over the eight cells round a node. Obstructions and what lies behind the
/// mesh's walls count with the value that they had at first (0 in a fire, TMPA of temperature),
/// what lies across its edges with 0; taking these out gives the mean of the gas.
struct SmokeScale {
  enum class Bytes { kNone, kOpacity, kDensity, kHeat, kTemperature };
  enum class Rounding { kUnknown, kDown, kNearest };

  SmokeQuantity quantity = SmokeQuantity::kExtinction;  ///< of physical values
  double massExtinction = kFdsMassExtinction;           ///< [m2/kg]
  double visibilityFactor = 3;
  double visibilityCap = 30;  ///< [m]
  Bytes bytes = Bytes::kNone;
  Rounding rounding = Rounding::kUnknown;       ///< of opacity
  double cellLength = 0;                        ///< [m], of opacity
  double largestDensity = 0;                    ///< [kg/m3], of b = 254
  double largestHeat = 0;                       ///< [kW/m3], of b = 254: HRRPUV_MAX_SMV
  std::array<double, 2> temperature{20, 2000};  ///< [degrees C], of b = 0 and 254: TEMP_MINMAX
  bool asStored = false;  ///< not smoke: physical values are taken as they are
  double step = 0;        ///< of physical values that were rounded

  /// Whether values stand for a range.
  bool inexact() const {
    return bytes != Bytes::kNone || step > 0 || quantity == SmokeQuantity::kVisibility;
  }

  /// Of a stored value. The value is NaN where that makes no sense.
  SmokeBand band(float stored) const;
};

/// The mean of the gas alone, from the mean `all` over the eight cells round a node and what these
/// are. `first` is the mean at the first stored time.
SmokeBand gasOnly(const SmokeBand& all, const SmokeBand& first, const NodeCells& cells);

/// The same of temperatures [degrees C], of which solids keep the ambient one. What is open counts
/// as that at most: across a face of it flames may be, or fresh air.
SmokeBand gasOnly(const SmokeBand& all, double ambient, const NodeCells& cells);

}  // namespace volute
