// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "volute/grid/frame_source.hpp"

namespace volute {

/// Which frames of a sequence, by their numbers n (what the input calls them, not positions):
/// begin <= n < end, every step-th from begin on, or from the first frame when no begin is given.
struct FrameRange {
  std::optional<int> begin;
  std::optional<int> end;
  int step = 1;  ///< >= 1

  bool operator==(const FrameRange&) const = default;
};

/// The positions of the frames that `range` selects, ascending; kInvalidArgument when there are
/// none.
[[nodiscard]] Result<std::vector<int>> selectPositions(const VolumeInfo& info,
                                                       const FrameRange& range);

/// The selected frames of `source` as a source of their own; they keep their numbers and times.
[[nodiscard]] Result<std::unique_ptr<FrameSource>> selectFrames(std::unique_ptr<FrameSource> source,
                                                                const FrameRange& range);

/// The range as a person writes it: "37:40", "0:100:5".
std::string toString(const FrameRange& range);

}  // namespace volute
