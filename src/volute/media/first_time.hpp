// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

namespace volute {

/// Of times that show so much each, one at least: the first if there is something to see, else the
/// first with at least half of the most.
inline std::size_t firstThatShows(std::span<const double> amounts) {
  constexpr double kSome = 0.2, kMuch = 0.5;  // of the most
  const double most = *std::ranges::max_element(amounts);
  const double least = amounts.front() >= kSome * most ? 0 : kMuch * most;
  const auto at = std::ranges::find_if(amounts, [&](double amount) { return amount >= least; });
  return static_cast<std::size_t>(at - amounts.begin());
}

}  // namespace volute
