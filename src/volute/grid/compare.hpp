// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "volute/base/progress.hpp"
#include "volute/grid/frame_source.hpp"

namespace volute {

/// How far B is from A. Accumulated in double; the same result for any cut into calls of add().
struct Difference {
  double sumOfSquares = 0;
  double maxError = 0;  ///< largest |b - a|
  double minA = 0, maxA = 0;
  std::uint64_t values = 0;

  /// Takes more values in; both spans have the same size. NaN on one side alone is an infinite
  /// error.
  void add(std::span<const float> a, std::span<const float> b);

  double rms() const;
  /// RMS / (max - min of A). A constant A has no range: 0 when B equals it, else infinity.
  double relativeRms() const;
  /// -20 log10(relativeRms()) [dB]; infinite when A and B are equal.
  double psnr() const;
};

/// Compares two sequences a frame at a time, in the order of their positions. kInvalidData when
/// their sizes differ.
/// @param byFrame  filled with one for each frame, when it is not null
[[nodiscard]] Result<Difference> compare(FrameSource& a, FrameSource& b, Progress& progress,
                                         std::vector<Difference>* byFrame = nullptr);

}  // namespace volute
