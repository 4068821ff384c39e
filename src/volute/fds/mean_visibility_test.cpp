// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/mean_visibility.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <random>

namespace volute {
namespace {

/// Cells of extinction, and what FDS stores of them at nodes.
struct CellsOfMeans {
  std::array<int, 3> size{};
  std::vector<double> k;

  double at(int x, int y, int z) const {
    return k[static_cast<std::size_t>((z * size[1] + y) * size[0] + x)];
  }

  /// The mean of `of` over the eight cells round each node within.
  template <class Of>
  std::vector<float> atNodes(Of&& of) const {
    std::vector<float> nodes;
    for (int z = 1; z < size[2]; ++z) {
      for (int y = 1; y < size[1]; ++y) {
        for (int x = 1; x < size[0]; ++x) {
          double sum = 0;
          for (int i = 0; i < 8; ++i) sum += of(at(x - (i & 1), y - (i >> 1 & 1), z - (i >> 2)));
          nodes.push_back(static_cast<float>(sum / 8));
        }
      }
    }
    return nodes;
  }
};

const SmokeScale kOfMeans{.quantity = SmokeQuantity::kVisibility};

double cutVisibility(double k) {
  return std::min(3 / std::max(k, 1e-9), 30.0);
}

/// A layer of smoke under clear air or the other way round, whose edge is as thin as two cells,
/// waves and gets thicker; fluctuations besides.
CellsOfMeans layer(std::mt19937& draw) {
  std::uniform_real_distribution<double> uniform(0, 1);
  std::normal_distribution<double> normal;
  CellsOfMeans cells{{9, 8, 10}, {}};
  const double thick = std::exp(4 * uniform(draw) - 2), clear = 0.02 * uniform(draw);
  const double middle = 1 + 8 * uniform(draw), width = 0.8 + 2 * uniform(draw);
  const double wave = uniform(draw), phase = 6 * uniform(draw);
  for (int z = 0; z < cells.size[2]; ++z) {
    for (int y = 0; y < cells.size[1]; ++y) {
      for (int x = 0; x < cells.size[0]; ++x) {
        const double edge = middle + wave * std::sin(0.7 * x + 0.5 * y + phase);
        const double share = 0.5 * (1 + std::tanh((z - edge) / width));
        cells.k.push_back((clear + thick * share) * std::exp(0.1 * normal(draw)));
      }
    }
  }
  return cells;
}

TEST(MeanVisibility, NoLimitIsPassedUnnoticedInLayersOfSmoke) {
  std::mt19937 draw(5);
  int missedByMeans = 0, nodes = 0, missed = 0, told = 0;
  for (int n = 0; n < 300; ++n) {
    const CellsOfMeans cells = layer(draw);
    const auto truth = cells.atNodes([](double k) { return k; });
    const auto stored = cells.atNodes(cutVisibility);
    const std::array<int, 3> size{8, 7, 9};
    const auto boxes = bandsOfMeans(kOfMeans, stored, size);
    for (int z = 0; z < size[2]; ++z) {
      const std::size_t first = static_cast<std::size_t>(z) * 56;
      const auto layers = bandsOfMeans(kOfMeans, std::span(stored).subspan(first, 56), {8, 7, 1});
      for (std::size_t i = 0; i < 56; ++i) {
        const double k = truth[first + i];
        const SmokeBand& flat = layers[i];
        const SmokeBand& box = boxes[first + i];
        EXPECT_LE(flat.low, k * (1 + 1e-5));
        EXPECT_LE(box.low, k * (1 + 1e-5));
        const std::size_t x = i % 8, y = i / 8;
        const bool within = x > 0 && x < 7 && y > 0 && y < 6 && z > 0 && z < 8;
        EXPECT_TRUE(!within || box.high * (1 + 1e-5) >= k);
        EXPECT_LE(flat.low, flat.value);
        EXPECT_GE(flat.high, flat.value);
        ++nodes;
        const bool lost = k >= 0.3;
        missedByMeans += lost && flat.value < 0.3F;
        missed += lost && (flat.high < 0.3F || box.high < 0.3F);
        told += !lost && flat.high >= 0.3F;
      }
    }
  }
  EXPECT_GT(missedByMeans, 1000);
  EXPECT_EQ(missed, 0);
  EXPECT_LT(told, nodes / 5) << "limits that may be passed, and are not";
}

TEST(MeanVisibility, EvenSmokeIsBoundedByAFactor) {
  const std::vector<float> stored(27, 6);
  const SmokeBand box = bandsOfMeans(kOfMeans, stored, {3, 3, 3})[13];
  EXPECT_FLOAT_EQ(box.value, 0.5);
  EXPECT_NEAR(box.low, box.value, 1e-5);
  EXPECT_NEAR(box.high, 0.5 * (1.5 + 1 / 1.5 - 1), 1e-5);
  const SmokeBand flat = bandsOfMeans(kOfMeans, std::span(stored).first(9), {3, 1, 3})[4];
  EXPECT_NEAR(flat.high, 0.5 * (3 + 1 / 3.0 - 1), 1e-5);
}

TEST(MeanVisibility, AtTheCapAllCellsAreAndSolidsCountForNothing) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<float> stored{30, 30, 2, 2, 0, kNan, 2, 2, -1};
  const auto bands = bandsOfMeans(kOfMeans, stored, {9, 1, 1});
  EXPECT_EQ(bands[1].low, 0);
  EXPECT_NEAR(bands[1].high, 0.1, 1e-6) << "a mean of eight that none exceeds";
  EXPECT_NEAR(bands[6].high, 1.5 * (3 + 1 / 3.0 - 1), 1e-5) << "not by what lies in solids";
  for (const int i : {4, 5, 8}) EXPECT_TRUE(std::isnan(bands[static_cast<std::size_t>(i)].value));
}

}  // namespace
}  // namespace volute
