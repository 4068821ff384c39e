// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/grid/frame_source.hpp"

namespace volute {

/// A source whose values may be rounded: numbers of another type become floats in it, or in a
/// source that it reads.
class RoundingSource : public FrameSource {
 public:
  /// How far the values read so far are at most from the numbers that they were made of.
  virtual double rounding() const = 0;
};

/// RoundingSource::rounding() of any source; 0 where it is none.
double roundingOf(const FrameSource& source);

}  // namespace volute
