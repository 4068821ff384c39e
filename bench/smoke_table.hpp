// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "bench/smoke_targets.hpp"
#include "volute/base/progress.hpp"

namespace volute::bench {

/// The four modes of one setting, by all drawers in turn, so that what else the machine does meets
/// all of them. Time is bounded: the baseline and what is held against it draw at least two
/// pictures of each mode, however slow; other slow drawers draw one, and in the first setting of an
/// eye alone; the slowest draw no more than one picture in all. Rows say so.
class SmokeTable {
 public:
  /// `stopped`: for each drawer why it draws no more, or empty; is added to.
  SmokeTable(const SmokeSetting& setting, const std::shared_ptr<const TetLocator>& locator,
             std::span<const std::unique_ptr<SmokeDrawer>> drawers, bool first,
             std::vector<std::string>& stopped);

  [[nodiscard]] Status measure(BenchRows& rows, SmokeTargets& targets, Progress& progress);

 private:
  struct Timing;

  BenchRow rowOf(const SmokeDrawer& drawer, const char* what) const;
  void judge(BenchRows& rows, SmokeTargets& targets);
  std::vector<Timing> draw(const SmokeMode& mode);

  SmokeSetting setting_;
  const std::shared_ptr<const TetLocator>& locator_;
  std::span<const std::unique_ptr<SmokeDrawer>> drawers_;
  bool first_;
  std::vector<std::string>& stopped_;
  std::vector<std::string> resting_;  // why a drawer draws no more in this setting, or empty
};

}  // namespace volute::bench
