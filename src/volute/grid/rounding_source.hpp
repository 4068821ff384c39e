// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>

#include "volute/grid/frame_source.hpp"

namespace volute {

/// A source whose values may be rounded: numbers of another type become floats in it, or in a
/// source that it reads.
class RoundingSource : public FrameSource {
 public:
  /// How far the values read so far are at most from the numbers that they were made of.
  virtual double rounding() const = 0;

  /// What a value is less than its number: values far from zero are read as differences from it.
  virtual double offset() const { return 0; }

  /// Whether its numbers may be none that a float is.
  virtual bool mayRound() const { return false; }

  /// Whether offsets can be taken off its numbers.
  virtual bool takesOffset() const { return false; }

  /// From now on values are differences from `offset`, which is a float.
  virtual void takeOffset(double offset) { (void)offset; }
};

/// One that reads layers for no more than they are of a frame.
class LayerwiseSource : public RoundingSource {
 public:
  [[nodiscard]] Status readFrame(int index, std::span<float> values) final {
    return readLayers(index, 0, info().z, values);
  }

  bool readsLayers() const override { return true; }

  [[nodiscard]] Status readLayers(int index, int first, int end,
                                  std::span<float> values) override = 0;
};

/// RoundingSource::rounding() of any source; 0 where it is none.
double roundingOf(const FrameSource& source);

/// RoundingSource::offset() of any source; 0 where it is none.
double offsetOf(const FrameSource& source);

/// What holds the values of any source, as OpenVDB calls it: doubles where there is an offset.
std::string typeOfValues(const FrameSource& source);

/// Which numbers far from zero are read as differences from an offset.
enum class Offsets {
  kNone,
  kOfRounded,  ///< those of which floats are others
  kAll,        ///< floats, too: a transform in float32 rounds them by more than they differ
};

/// Gives a source the offset from which its values, but for those that are 0 or not finite, are far
/// less away than from zero: in the middle of them. None where that gains nothing. Reads the source
/// up to the values that tell it.
[[nodiscard]] Status settleOffset(FrameSource& source, Offsets which = Offsets::kAll);

/// `by` more in all that a frame holds, its background too.
Bricks raised(const Bricks& frame, double by);

}  // namespace volute
