// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/clock.hpp"

#include <cmath>

namespace volute {

double Clock::at(double time, std::span<const double> times) const {
  const double own = offset + rate * time;
  if (!loop || times.size() < 2)
    return own;
  const double last = times.back() - times[times.size() - 2];
  const double period = times.back() - times.front() + last;
  return own - period * std::floor((own - times.front()) / period);
}

}  // namespace volute
