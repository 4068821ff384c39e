// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/mode_search.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace volute {
namespace {

BlockMode asItIs(const BlockMode& mode) {
  return mode;
}

/// Costs that grow with the distance to a mode, and how often they were asked for.
struct Valley {
  BlockMode lowest;
  std::vector<BlockMode> tried{};

  double operator()(const BlockMode& mode) {
    EXPECT_EQ(std::ranges::find(tried, mode), tried.end()) << describe(mode) << " again";
    tried.push_back(mode);
    return 1 + (mode.shaped != lowest.shaped) + (mode.wavelet != lowest.wavelet) +
           std::abs(std::log2(1.0 + mode.timeLevels) - std::log2(1.0 + lowest.timeLevels));
  }
};

TEST(ModeSearch, FindsTheLowestPlaceOfAnyValleyFromAnywhere) {
  for (const BlockMode& lowest : allBlockModes()) {
    for (const BlockMode& start : allBlockModes()) {
      Valley valley{lowest};
      ModeSearch search(allBlockModes(), asItIs,
                        [&](const BlockMode& mode) { return valley(mode); });
      search.tryMode(start);
      search.descend();
      EXPECT_EQ(search.best(), lowest) << describe(start);
      EXPECT_DOUBLE_EQ(search.minCost(), 1);
      EXPECT_LE(valley.tried.size(), 16u) << describe(lowest) << " from " << describe(start);
    }
  }
}

TEST(ModeSearch, TriesCandidatesAloneAndEachOnce) {
  std::vector<BlockMode> candidates;
  for (const BlockMode& mode : allBlockModes()) {
    if (mode.wavelet == Wavelet::kHaar)
      candidates.push_back(mode);
  }
  const BlockMode elsewhere{false, Wavelet::kCdf97, 4};
  Valley valley{{true, Wavelet::kCdf53, 2}};
  ModeSearch search(candidates, asItIs, [&](const BlockMode& mode) { return valley(mode); });
  search.tryMode(elsewhere);
  search.descend();
  EXPECT_FALSE(search.best());
  EXPECT_TRUE(valley.tried.empty());
  search.tryMode({false, Wavelet::kHaar, 4});
  search.tryAll();
  search.descend();
  EXPECT_EQ(search.best(), (BlockMode{true, Wavelet::kHaar, 2}));
  EXPECT_EQ(valley.tried.size(), candidates.size());
}

TEST(ModeSearch, TriesTheSimplestOfModesThatAreTheSame) {
  Valley valley{{true, Wavelet::kCdf97, 4}};
  const auto plainOfTwo = [](BlockMode mode) {
    mode.shaped = false;
    mode.timeLevels = std::min(mode.timeLevels, 2);
    return mode;
  };
  ModeSearch search(allBlockModes(), plainOfTwo,
                    [&](const BlockMode& mode) { return valley(mode); });
  search.tryMode({true, Wavelet::kHaar, 4});
  search.descend();
  EXPECT_EQ(search.best(), (BlockMode{false, Wavelet::kCdf97, 2}));
  search.tryAll();
  EXPECT_EQ(valley.tried.size(), 9u);
}

TEST(ModeSearch, NothingIsBestWithoutAFiniteCost) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const double cost : {kInfinity, std::numeric_limits<double>::quiet_NaN()}) {
    ModeSearch search(allBlockModes(), asItIs, [&](const BlockMode&) { return cost; });
    search.tryAll();
    search.descend();
    EXPECT_FALSE(search.best());
  }
}

}  // namespace
}  // namespace volute
