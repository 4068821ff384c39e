// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fog/fog_detail.hpp"

#include <cmath>
#include <limits>

namespace volute {

FogDetail::Ends FogDetail::ends(int levels, double cell, double distance) const {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Ends ends;
  ends.fill(kInfinity);
  if (finestOnly())
    return ends;
  for (int level = 0; level < levels; ++level) {
    if (cellAngle > 0) {
      ends[level] = std::ldexp(cell, level + 1) / cellAngle;
    } else {
      ends[level] = mu <= 0 ? 0 : std::pow(mu, levels - level) * distance;
    }
  }
  return ends;
}

}  // namespace volute
