// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "volute/base/remark.hpp"

namespace volute {

/// Where the frames of a file are, and when.
struct FdsFrameIndex {
  std::vector<double> times;           ///< [s], strictly ascending
  std::vector<std::uint64_t> offsets;  ///< of each frame's first record
  std::vector<Remark> remarks;         ///< truncation and restarts, each with file and frame

  /// Adds a frame. A time that is not later than the last one is where FDS was started again: the
  /// frames from that time on are replaced.
  void add(double time, std::uint64_t offset, const std::string& file);
};

/// The place of the time that is nearest to `time`; of two as near the first. `times` is ascending
/// and not empty.
std::size_t nearestFrame(std::span<const double> times, double time);

}  // namespace volute
