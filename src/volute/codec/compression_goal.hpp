// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cmath>
#include <cstdint>
#include <string_view>

#include "volute/codec/compress.hpp"
#include "volute/codec/step_search.hpp"
#include "volute/wavelet/quantiser.hpp"

namespace volute {

/// "support-rms", "look", "rms", "psnr", "ratio", "size", "max-error".
std::string_view nameOf(ErrorTarget::Kind kind);

/// The target of a compression, and the quantisation steps expected to reach it.
class CompressionGoal {
 public:
  CompressionGoal(const ErrorTarget& target, const VolumeInfo& info)
      : target_(target), rawBytes_(info.rawBytes()), goal_(target.value) {}

  /// What errors are relative to, before all that follows: the range, and how many values they are
  /// spread over.
  /// @param greatest  of the magnitudes that may be coded by coefficients
  /// @param own  that of the support, which the background beside it may be far from
  /// @param constant  all voxels are equal: clamping makes them exact whatever the step
  void setRange(double low, double high, double greatest, double own, double values,
                bool constant) {
    low_ = low, high_ = high, greatest_ = greatest, values_ = values, constant_ = constant;
    own_ = own > 0 ? own : greatest;
  }

  /// Asks for so much more that the goal is met after rounding to 16-bit floats.
  /// @param rounding  the RMS of that rounding, over the values that the goal is about
  /// @param offset  of all values
  void leaveRoomForHalves(double rounding, double offset);

  /// Asks for so much more that the goal is met by the numbers that were rounded to the values, at
  /// most that far. kUnsupported, with the target that can be met, where the rounding alone misses
  /// it.
  [[nodiscard]] Status leaveRoomFor(double rounding);

  const ErrorTarget& target() const { return target_; }

  /// A ratio or a size of the file, not an error.
  bool isSize() const;

  bool isMaxError() const { return target_.kind == ErrorTarget::Kind::kMaxError; }

  /// The error to reach: `target` less the room left for rounding.
  double value() const { return goal_; }

  /// An RMS over a range; where there is none over the values themselves.
  static double relative(double rms, double low, double high) {
    const double one = std::abs(high) > 0 ? std::abs(high) : 1;
    return rms / (high > low ? high - low : one);
  }

  double relative(double rms) const { return relative(rms, low_, high_); }

  /// The search for a step by its outcome: a relative RMS, or the bytes of the file. Not for a
  /// maximum error, which is kept whatever the step.
  StepSearch::Problem problem() const;

  /// What a survey of the coefficients says of steps.
  void setModel(const QuantisationModel& model) { model_ = &model; }

  /// The step that the survey predicts to meet the goal.
  double firstStep() const;

  /// The step that should come to the part `aim` of the goal, from what another gave.
  /// @param errorPower  the power of the error that the step goes with
  double betterStep(double step, double outcome, double aim, double errorPower) const;

 private:
  double within(double step) const;

  ErrorTarget target_;
  std::uint64_t rawBytes_ = 0;
  double goal_ = 0;
  double low_ = 0, high_ = 0, greatest_ = 0, own_ = 0, values_ = 0;
  bool constant_ = false;
  const QuantisationModel* model_ = nullptr;
};

}  // namespace volute
