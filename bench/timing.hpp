// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <chrono>
#include <vector>

namespace volute::bench {

using Clock = std::chrono::steady_clock;

inline double secondsSince(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// The seconds that `work` takes.
template <class Work>
double secondsOf(Work&& work) {
  const auto begin = Clock::now();
  work();
  return secondsSince(begin);
}

/// The median of the seconds that `work` takes, over at least three runs that together take
/// `minimumSeconds`.
template <class Work>
double medianSeconds(Work&& work, double minimumSeconds = 0.3) {
  constexpr std::size_t kMinimumRuns = 3;
  std::vector<double> runs;
  for (double total = 0; runs.size() < kMinimumRuns || total < minimumSeconds; total += runs.back())
    runs.push_back(secondsOf(work));
  std::ranges::nth_element(runs, runs.begin() + static_cast<std::ptrdiff_t>(runs.size() / 2));
  return runs[runs.size() / 2];
}

}  // namespace volute::bench
