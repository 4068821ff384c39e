// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <string_view>

#include "volute/codec/compress.hpp"
#include "volute/codec/step_search.hpp"
#include "volute/wavelet/quantiser.hpp"

namespace volute {

/// "rms", "psnr", "ratio", "size", "max-error".
std::string_view nameOf(ErrorTarget::Kind kind);

/// What is asked of a compression, and the quantisation steps that should give it.
class CompressionGoal {
 public:
  CompressionGoal(const ErrorTarget& target, const VolumeInfo& info)
      : target_(target), rawBytes_(info.rawBytes()), values_(info.values()), goal_(target.value) {}

  /// The least and the greatest value of the input; before all that follows.
  void setRange(double valueMin, double valueMax) { valueMin_ = valueMin, valueMax_ = valueMax; }

  /// Asks for so much more that the goal is met after rounding to 16-bit floats.
  void leaveRoomForHalves();

  /// Asks for so much more that the goal is met by the numbers that were rounded to the values, at
  /// most that far. kUnsupported, with the target that can be met, where the rounding alone misses
  /// it.
  [[nodiscard]] Status leaveRoomFor(double rounding);

  const ErrorTarget& target() const { return target_; }

  /// A ratio or a size of the file, not an error.
  bool isSize() const;

  bool isMaxError() const { return target_.kind == ErrorTarget::Kind::kMaxError; }

  /// As `target`, after room was left.
  double value() const { return goal_; }

  /// An RMS over the range, which is that RMS itself where there is none.
  double relative(double rms) const {
    return valueMax_ > valueMin_ ? rms / (valueMax_ - valueMin_) : rms;
  }

  /// The search for a step by its outcome: a relative RMS, or the bytes of the file. Not for a
  /// maximum error, which is kept whatever the step.
  StepSearch::Problem problem() const;

  /// The step that a survey of the coefficients predicts to meet the goal.
  double firstStep(const QuantisationModel& model) const;

  /// The step that should meet the goal, from what another gave.
  double betterStep(double step, double outcome) const;

 private:
  double within(double step) const;

  ErrorTarget target_;
  std::uint64_t rawBytes_ = 0, values_ = 0;
  double goal_ = 0;
  double valueMin_ = 0, valueMax_ = 0;
};

}  // namespace volute
