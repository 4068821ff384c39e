// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <chrono>

namespace volute {

/// Adds the milliseconds of its life to a total.
class Stopwatch {
 public:
  explicit Stopwatch(double& total) : total_(total) {}

  ~Stopwatch() {
    total_ += std::chrono::duration<double, std::milli>(Clock::now() - begin_).count();
  }

  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  using Clock = std::chrono::steady_clock;

  double& total_;
  Clock::time_point begin_ = Clock::now();
};

}  // namespace volute
