// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <vector>

#include "volute/base/result.hpp"
#include "volute/grid/frame_source.hpp"

namespace volute {

/// Statistics for the automatic choice of an appearance: how large and how dense the values of one
/// channel are.
struct LookFigures {
  double least = 0, most = 0;  ///< of some frames, and of 0
  /// Integral along z of a dense column, of positive values [value x m], the largest of these
  /// frames: nine in ten of the columns that hold something are less dense.
  double column = 0;

  bool any() const { return most > 0; }

  bool operator==(const LookFigures&) const = default;
};

/// Reads the frames that they are of: at most three, spread over the sequence.
[[nodiscard]] Result<LookFigures> lookFigures(FrameSource& source);

/// Frames whose source knows without reading them how much is in each.
class CountedFrames {
 public:
  virtual ~CountedFrames() = default;

  /// Of each frame, in any unit; empty: it does not know.
  virtual std::vector<double> amounts() const = 0;
};

}  // namespace volute
