// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>

namespace volute {

/// Looks for the coarsest quantisation step whose outcome (an error, or a size) stays at or below a
/// target, and close to it, in few tries. Errors grow with the step, sizes shrink.
class StepSearch {
 public:
  struct Problem {
    double target = 0;                ///< the outcome must be <= this
    double closeEnough = 0;           ///< and an outcome >= this ends the search
    bool grows = true;                ///< whether the outcome grows with the step
    double finest = 0, coarsest = 0;  ///< limits of the step
    int maxTries = 8;
    /// How outcomes go with steps, up to a factor that hardly depends on the step; monotone.
    /// Without it outcomes are powers of the step.
    std::function<double(double step)> predict{};

    /// The step between these two at which `predict` gives `value`.
    double stepOf(double value, double finer, double coarser) const;
  };

  StepSearch(const Problem& problem, double first);

  /// The step to try next, or the one that was found.
  double step() const { return step_; }

  /// What step() gave. When found() is true afterwards, it was the last try and met the target;
  /// when failed() is, no step can; else try step() again.
  void tell(double outcome);

  bool found() const { return found_; }

  bool failed() const { return failed_; }

 private:
  struct Try {
    double step = 0, outcome = 0;
    bool known = false;
  };

  double proposal() const;
  double between(double aim) const;

  Problem problem_;
  double step_;
  Try good_, bad_;  // the best that met the target, the nearest that did not
  int limit_;       // of tries, so far
  int tries_ = 0;
  bool found_ = false, failed_ = false;
};

}  // namespace volute
