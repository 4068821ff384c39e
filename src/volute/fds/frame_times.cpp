// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/frame_times.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace volute {

void FdsFrameIndex::add(double time, std::uint64_t offset, const std::string& file) {
  if (!times.empty() && time <= times.back()) {
    remarks.push_back(
        fmt::format("{}: byte {}: the times go back from {} s to {} s (a restart): the later "
                    "frames are used",
                    file, offset, times.back(), time));
    while (!times.empty() && times.back() >= time) {
      times.pop_back();
      offsets.pop_back();
    }
  }
  times.push_back(time);
  offsets.push_back(offset);
}

std::size_t nearestFrame(std::span<const double> times, double time) {
  const auto after = std::ranges::lower_bound(times, time);
  if (after == times.begin())
    return 0;
  const auto place = static_cast<std::size_t>(after - times.begin());
  return after != times.end() && *after - time < time - times[place - 1] ? place : place - 1;
}

}  // namespace volute
