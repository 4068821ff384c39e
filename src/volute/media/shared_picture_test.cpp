// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/shared_picture.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "volute/base/team_testing.hpp"
#include "volute/medium/integrate.hpp"

namespace volute {
namespace {

/// Pieces of all lengths, some with a gap before them.
std::vector<Piece> manyPieces(int count) {
  std::vector<Piece> pieces;
  double at = 0.5;
  for (int i = 0; i < count; ++i) {
    if (i % 5 == 3)
      at += 0.25;
    Piece piece;
    piece.begin = at;
    piece.end = at += 0.05 + 0.01 * (i % 7);
    piece.extinction = {{0.5 + 0.1 * (i % 3), 0.2}};
    for (int c = 0; c < 3; ++c) piece.emission[c] = {{0.3 * (c + 1) + 0.05 * i}};
    pieces.push_back(piece);
  }
  return pieces;
}

std::vector<HeldRun> runsOf(const std::vector<Piece>& pieces) {
  return heldRuns(std::span(&pieces, 1));
}

TEST(SharedPicture, RunsBreakWhereThereIsAGap) {
  const auto runs = runsOf(manyPieces(10));
  ASSERT_EQ(runs.size(), 3u);
  EXPECT_EQ(runs[0].begin, 0.5);
  EXPECT_LT(runs[0].end, runs[1].begin);
  EXPECT_TRUE(heldRuns({}).empty());
}

// Whoever holds a piece, and however often the ray goes from one to another.
TEST(SharedPicture, PiecesOfRanksComeToWhatAllOfThemDo) {
  const auto pieces = manyPieces(40);
  const Radiance expected = composite(pieces);
  constexpr std::size_t kPixels = 70000;  // more than are exchanged together
  for (const int ranks : {1, 2, 3, 5}) {
    onRanks(ranks, [&](Team& team) {
      std::vector<Piece> own;
      for (std::size_t i = 0; i < pieces.size(); ++i) {
        if (static_cast<int>(i / 3) % team.size() == team.rank())
          own.push_back(pieces[i]);
      }
      const auto runs = runsOf(own);
      std::vector<float> rgbt(4 * kPixels, -1);
      composeRuns(
          team,
          [&](std::size_t pixel) { return pixel % 1000 == 7 ? runs : std::vector<HeldRun>(); },
          rgbt);
      for (const std::size_t pixel : {std::size_t{7}, std::size_t{69007}}) {
        for (int c = 0; c < 3; ++c)
          EXPECT_NEAR(rgbt[4 * pixel + static_cast<std::size_t>(c)], expected.emitted[c], 1e-5);
        EXPECT_NEAR(rgbt[4 * pixel + 3], expected.transmittance, 1e-5);
      }
      EXPECT_EQ(rgbt[0], 0);
      EXPECT_EQ(rgbt[3], 1);
    });
  }
}

TEST(SharedPicture, ARayBetweenTwoPiecesMeetsOneOfThem) {
  const auto runs = runsOf(manyPieces(20));
  const Radiance expected = composite(manyPieces(20));
  onRanks(2, [&](Team& team) {
    std::vector<float> rgbt(4);
    composeRuns(team, [&](std::size_t) { return runs; }, rgbt);
    EXPECT_NEAR(rgbt[0], expected.emitted[0], 1e-5);
    EXPECT_NEAR(rgbt[3], expected.transmittance, 1e-5);
  });
}

// Light that fills a gap of the smoke joins two runs, and both media count where they overlap.
TEST(SharedPicture, RunsOfSeveralMediaAreTheirUnion) {
  const std::vector<Piece> smoke = manyPieces(10);
  Piece fire;
  fire.begin = smoke[2].begin + 0.01, fire.end = smoke[3].end - 0.01;
  for (int c = 0; c < 3; ++c) fire.emission[c] = {{2.0 - c}};
  const std::vector<std::vector<Piece>> both{smoke, {fire}};
  const auto runs = heldRuns(both);
  ASSERT_EQ(runs.size(), 2u);
  EXPECT_EQ(runs[0].end, runsOf(smoke)[1].end);
  const Radiance expected = compositeMedia(both);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(
        runs[0].radiance.emitted[c] + runs[0].radiance.transmittance * runs[1].radiance.emitted[c],
        expected.emitted[c], 1e-9);
  }
}

// All ranks learn of one that leaves with an error in the middle of a picture.
TEST(SharedPicture, AnErrorOfOneRankEndsAll) {
  onRanks(3, [](Team& team) {
    if (team.rank() == 1) {
      EXPECT_FALSE(team.agree(fail(ErrorCode::kIo, "no such file")));
      return;
    }
    std::vector<float> rgbt(4 * 100);
    composeRuns(team, [](std::size_t) { return std::vector<HeldRun>(); }, rgbt);
    const Status after = team.agree({});
    ASSERT_FALSE(after);
    EXPECT_EQ(after.error().message, "rank 1: no such file");
  });
}

TEST(SharedPicture, DepthsAddUp) {
  onRanks(3, [](Team& team) {
    std::vector<float> depth(70000, static_cast<float>(team.rank() + 1));
    depth.back() = team.rank() == 1 ? 2.5F : 0;
    sumDepths(team, depth);
    EXPECT_EQ(depth.front(), 6);
    EXPECT_EQ(depth.back(), 2.5F);
  });
}

}  // namespace
}  // namespace volute
