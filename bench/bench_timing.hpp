// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <chrono>
#include <vector>

namespace volute::bench {

/// The median of the seconds that `work` takes, over at least three runs that together take
/// `leastSeconds`.
template <class Work>
double medianSeconds(Work&& work, double leastSeconds = 0.3) {
  using Clock = std::chrono::steady_clock;
  constexpr std::size_t kLeastRuns = 3;
  std::vector<double> runs;
  for (double total = 0; runs.size() < kLeastRuns || total < leastSeconds; total += runs.back()) {
    const auto begin = Clock::now();
    work();
    runs.push_back(std::chrono::duration<double>(Clock::now() - begin).count());
  }
  std::ranges::nth_element(runs, runs.begin() + static_cast<std::ptrdiff_t>(runs.size() / 2));
  return runs[runs.size() / 2];
}

}  // namespace volute::bench
