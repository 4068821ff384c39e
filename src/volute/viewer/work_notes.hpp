// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "volute/viewer/cpu_thread.hpp"

namespace volute {

/// Work that a person is told of, because it takes longer than a blink.
struct ViewerWork {
  std::string text{};  ///< empty: nothing
  double share = -1;   ///< 0..1; negative when nobody knows
  bool stops = false;  ///< it can be stopped
  bool stale = false;  ///< what is shown is not what was asked for
};

/// What is said about work and about what was done last, and for how long.
class WorkNotes {
 public:
  struct Seen {
    bool loads = false;
    std::string stage{};  ///< of loading
    double loaded = 0;    ///< share, 0..1; negative when nobody knows
    bool draws = false;
    CpuProgress drawn{};
    std::optional<double> report{};      ///< share of one that is written, 0..1
    std::optional<double> reportLeft{};  ///< [s]
    bool shown = false;                  ///< there is a picture
    bool late = false;                   ///< and it is of something else
    std::string lack{};                  ///< what it is of, where nothing else can be shown
  };

  /// To be called in every frame.
  void update(const Seen& seen, const std::string& message);

  const ViewerWork& work() const { return work_; }

  /// The last message, for some seconds; empty: nothing.
  const std::string& toast() const { return toast_; }

 private:
  using Clock = std::chrono::steady_clock;

  static double lasting(bool is, std::optional<Clock::time_point>& since);

  ViewerWork work_;
  std::optional<Clock::time_point> workingSince_, staleSince_, toastUntil_;
  std::string toast_, toasted_;  // what is shown, and the last message that was
};

}  // namespace volute
