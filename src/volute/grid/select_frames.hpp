// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "volute/grid/frame_source.hpp"

namespace volute {

/// Which frames of a sequence, by their numbers n (what the input calls them, not positions):
/// begin <= n < end, and of those with a step above 1 each that lies a multiple of it after begin,
/// or after the first frame when no begin is given.
struct FrameRange {
  std::optional<double> begin;
  std::optional<double> end;
  int step = 1;  ///< >= 1; 1: all, those between whole numbers too

  bool operator==(const FrameRange&) const = default;

  static FrameRange only(double frame);  ///< this one
};

/// The positions of the numbers that `range` selects, ascending; none where there are none.
std::vector<int> selectPositions(std::span<const int> numbers, FrameScale scale,
                                 const FrameRange& range);

/// The positions of the frames that `range` selects, ascending; kInvalidArgument when there are
/// none.
[[nodiscard]] Result<std::vector<int>> selectPositions(const VolumeInfo& info,
                                                       const FrameRange& range);

/// The selected frames of `source` as a source of their own; they keep their numbers and times.
[[nodiscard]] Result<std::unique_ptr<FrameSource>> selectFrames(std::unique_ptr<FrameSource> source,
                                                                const FrameRange& range);

/// What a user states of a sequence instead of its files.
struct StatedInfo {
  std::optional<double> framesPerSecond{};  ///< times by the frames' numbers
  char up = 0;                              ///< VolumeInfo::up; 0: as it is

  bool operator==(const StatedInfo&) const = default;
};

std::unique_ptr<FrameSource> asStated(std::unique_ptr<FrameSource> source,
                                      const StatedInfo& stated);

/// "frames 2:99 are asked for; it has 0 to 3", where a range begins or ends farther from `numbers`,
/// ascending, than one step of theirs; else empty.
std::string beyondText(const FrameRange& range, std::span<const int> numbers, FrameScale scale);

/// The range as a person writes it: "37", "37:40", "0:100:5".
std::string toString(const FrameRange& range);

}  // namespace volute
