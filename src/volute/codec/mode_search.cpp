// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/mode_search.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace volute {

ModeSearch::ModeSearch(std::span<const BlockMode> candidates, Simplest simplest, CostOf costOf)
    : simplest_(std::move(simplest)), costOf_(std::move(costOf)) {
  for (const BlockMode& candidate : candidates) {
    const BlockMode mode = simplest_(candidate);
    if (std::ranges::find(left_, mode) == left_.end())
      left_.push_back(mode);
  }
}

void ModeSearch::tryMode(const BlockMode& candidate) {
  const auto at = std::ranges::find(left_, simplest_(candidate));
  if (at == left_.end())
    return;
  const BlockMode mode = *at;
  left_.erase(at);
  const double cost = costOf_(mode);
  tried_.emplace_back(cost, mode);
  if (!(cost < minCost_))
    return;
  best_ = mode;
  minCost_ = cost;
}

void ModeSearch::tryAll() {
  while (!left_.empty()) tryMode(BlockMode(left_.front()));
}

std::vector<BlockMode> ModeSearch::cheapest(std::size_t count) const {
  auto all = tried_;
  std::ranges::stable_sort(all, {}, [](const auto& one) { return one.first; });
  std::vector<BlockMode> modes;
  for (std::size_t i = 0; i < std::min(count, all.size()); ++i) modes.push_back(all[i].second);
  return modes;
}

void ModeSearch::descend() {
  constexpr std::array kTimeLevels{0, 1, 2, 4};
  std::optional<BlockMode> from;
  while (best_ && best_ != from) {
    from = best_;
    BlockMode mode = *best_;
    for (const Wavelet wavelet : {Wavelet::kHaar, Wavelet::kCdf53, Wavelet::kCdf97})
      tryMode({mode.shaped, wavelet, mode.timeLevels});
    mode = *best_;
    const auto* levels = std::ranges::find(kTimeLevels, mode.timeLevels);
    if (levels != kTimeLevels.begin())
      tryMode({mode.shaped, mode.wavelet, levels[-1]});
    if (levels + 1 < kTimeLevels.end())
      tryMode({mode.shaped, mode.wavelet, levels[1]});
    mode = *best_;
    tryMode({!mode.shaped, mode.wavelet, mode.timeLevels});
  }
}

}  // namespace volute
