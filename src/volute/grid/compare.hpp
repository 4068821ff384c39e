// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "volute/base/progress.hpp"
#include "volute/grid/frame_source.hpp"
#include "volute/grid/index_box.hpp"

namespace volute {

/// How far B is from A. Accumulated in double. The support is what A has active or not equal to its
/// background.
struct Difference {
  double sumOfSquares = 0;
  double maxError = 0;  ///< largest |b - a|
  double minA = 0, maxA = 0;
  std::uint64_t values = 0;

  double supportSquares = 0;
  std::uint64_t supportValues = 0;
  double supportLow = 0, supportHigh = 0;  ///< the range of A's support
  bool robust = false;                     ///< that is ValueHistogram::robustRange()
  double outsideError = 0;                 ///< largest |b - a| outside of the support

  int worstFrame = 0;              ///< position of the frame with the largest error
  VoxelIndex worst{};              ///< its voxel
  double worstA = 0, worstB = 0;   ///< what is there
  bool backgroundsDiffer = false;  ///< what A and B are where neither of them holds anything

  /// Takes more values in; both spans have the same size. NaN on one side alone is an infinite
  /// error.
  void add(std::span<const float> a, std::span<const float> b);

  /// Takes `count` pairs of equal values in.
  /// @param apart  what a's numbers are more than b's where their values are the same
  /// @return  whether their error is the largest so far
  bool add(float a, float b, bool support, std::uint64_t count = 1, double apart = 0);

  /// A's and B's values were differences from these.
  void shift(double offsetA, double offsetB);

  double rms() const;
  /// RMS / (max - min of A). A constant A has no range: 0 when B equals it, else infinity.
  double relativeRms() const;
  /// -20 log10(relativeRms()) [dB]; infinite when A and B are equal.
  double psnr() const;
  /// RMS over the support, relative to its range; a support of one value has the range of all of A.
  double supportRms() const;
  /// The support's part of all values.
  double supportShare() const;
};

/// Compares two sequences a frame at a time, in the order of their positions: what is in them, and
/// in one step what lies between. kInvalidData when their sizes differ.
/// @param byFrame  filled with one for each frame, when it is not null
[[nodiscard]] Result<Difference> compare(FrameSource& a, FrameSource& b, Progress& progress,
                                         std::vector<Difference>* byFrame = nullptr);

}  // namespace volute
