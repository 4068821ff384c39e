// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/plain_number.hpp"

#include <fmt/format.h>

#include <cmath>

namespace volute {

std::string plainNumber(double value, int digits) {
  constexpr double kLarge = 999.95, kNone = 1e12;  // beyond which it is neither
  const double size = std::abs(value);
  if (!(size >= kLarge && size < kNone))
    return fmt::format("{:.{}g}", value, digits);
  return fmt::format("{:.15g}", std::round(100 * value) / 100);
}

}  // namespace volute
