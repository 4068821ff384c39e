// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>

namespace volute {

/// A medium's own time: offset + rate * the scene's time [s].
struct Clock {
  double offset = 0;
  double rate = 1;    ///< > 0
  bool loop = false;  ///< begins again after its last frame, which lasts as long as the one before

  /// The medium's own time at a time of the scene [s].
  /// @param times  of its stored frames in its own time, ascending, at least one [s]
  double at(double time, std::span<const double> times) const;

  /// The scene's time at which the medium's own first is `own` [s].
  double sceneTime(double own) const { return (own - offset) / rate; }

  bool operator==(const Clock&) const = default;
};

}  // namespace volute
