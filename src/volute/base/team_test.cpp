// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/team.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <set>
#include <thread>

#include "volute/base/gather_values.hpp"
#include "volute/base/ordered_delivery.hpp"
#include "volute/base/team_testing.hpp"

namespace volute {
namespace {

using testing::HasSubstr;

TEST(Team, DoesEachUnitOnceOnAnyNumberOfRanks) {
  for (const int ranks : {1, 2, 3, 8}) {
    std::mutex mutex;
    std::multiset<std::int64_t> done;
    onRanks(ranks, [&](Team& team) {
      Progress progress;
      for (int round = 0; round < 2; ++round) {
        ASSERT_TRUE(team.forUnits("work", 20, progress, [&](std::int64_t unit) -> Status {
          const std::lock_guard lock(mutex);
          done.insert(unit);
          return {};
        }));
      }
      std::uint64_t count = team.units().front().units.size();
      ASSERT_TRUE(team.sum({&count, 1}));
      EXPECT_EQ(count, 40U);
    });
    ASSERT_EQ(done.size(), 40U);
    for (std::int64_t unit = 0; unit < 20; ++unit) EXPECT_EQ(done.count(unit), 2U);
  }
}

TEST(Team, WhoStopsAtOnceGetsNoUnit) {
  struct : Progress {
    void report(std::string_view /*stage*/, double done, double /*total*/) override {
      stopped = stopped || done == 0;
    }

    bool cancelled() const override { return stopped; }

    bool stopped = false;
  } progress;

  Team alone;
  const Status done = alone.forUnits("work", 2, progress, [](std::int64_t) -> Status {
    ADD_FAILURE();
    return {};
  });
  EXPECT_EQ(done.error().code, ErrorCode::kCancelled);
}

TEST(Team, EachRankSendsToEach) {
  onRanks(3, [](Team& team) {
    std::vector<std::vector<int>> toEach;
    for (int rank = 0; rank < 3; ++rank)
      toEach.emplace_back(static_cast<std::size_t>(rank + team.rank()), 10 * team.rank() + rank);
    const auto received = exchangeValues(team, std::span<const std::vector<int>>(toEach));
    ASSERT_TRUE(received);
    ASSERT_EQ(received->size(), 3U);
    for (int rank = 0; rank < 3; ++rank) {
      const std::vector<int> expected(static_cast<std::size_t>(rank + team.rank()),
                                      10 * rank + team.rank());
      EXPECT_EQ((*received)[static_cast<std::size_t>(rank)], expected);
    }
  });
  Team alone;
  const std::vector<std::vector<int>> own{{1, 2, 3}};
  EXPECT_EQ(*exchangeValues(alone, std::span<const std::vector<int>>(own)), own);
}

// Units of uneven cost, one of them as long as a tenth of all: whoever is free takes the next.
TEST(Team, NoRankDoesMoreThanTwiceItsShare) {
  using namespace std::chrono_literals;
  constexpr int kRanks = 4, kUnits = 100;
  std::vector<std::chrono::microseconds> cost;
  for (int unit = 0; unit < kUnits; ++unit)
    cost.push_back(unit == 30 ? 30ms : 500us * (1 + unit % 10));
  std::vector<std::vector<std::int64_t>> units(kRanks);
  onRanks(kRanks, [&](Team& team) {
    Progress progress;
    ASSERT_TRUE(team.forUnits("work", kUnits, progress, [&](std::int64_t unit) -> Status {
      std::this_thread::sleep_for(cost[static_cast<std::size_t>(unit)]);
      return {};
    }));
    units[static_cast<std::size_t>(team.rank())] = team.units().front().units;
  });
  std::vector<int> done(kUnits, 0);
  std::chrono::microseconds all{0}, most{0};
  for (const auto& ofRank : units) {
    std::chrono::microseconds sum{0};
    for (const std::int64_t unit : ofRank) {
      ++done[static_cast<std::size_t>(unit)];
      sum += cost[static_cast<std::size_t>(unit)];
    }
    all += sum;
    most = std::max(most, sum);
    EXPECT_TRUE(std::ranges::is_sorted(ofRank));
  }
  EXPECT_EQ(done, std::vector<int>(kUnits, 1));
  EXPECT_LE(most, 2 * all / kRanks);
}

TEST(Team, AloneIsTheTeamOfOne) {
  Team team;
  Progress progress;
  std::vector<std::int64_t> units;
  ASSERT_TRUE(team.forUnits("work", 3, progress, [&](std::int64_t unit) -> Status {
    units.push_back(unit);
    return {};
  }));
  EXPECT_EQ(units, (std::vector<std::int64_t>{0, 1, 2}));
  EXPECT_EQ(*team.broadcast(0.1), 0.1);
}

TEST(Team, AnErrorOfOneUnitIsTheErrorOfAllRanks) {
  onRanks(4, [](Team& team) {
    Progress progress;
    const Status status = team.forUnits("work", 1000, progress, [](std::int64_t unit) -> Status {
      return unit == 7 ? Status(fail(ErrorCode::kIo, "the disk is full")) : Status();
    });
    ASSERT_FALSE(status);
    EXPECT_EQ(status.error().code, ErrorCode::kIo);
    EXPECT_THAT(status.error().message, HasSubstr("the disk is full"));
    EXPECT_FALSE(team.agree({})) << "a team that failed does not go on";
    EXPECT_FALSE(team.gatherAll({}));
  });
}

// A rank that finds no file leaves before the others' first collective call, whichever that is.
TEST(Team, ARankThatLeavesEndsTheOthers) {
  onRanks(3, [](Team& team) {
    if (team.rank() == 1) {
      EXPECT_FALSE(team.agree(fail(ErrorCode::kNotFound, "no such file")));
      return;
    }
    std::uint64_t number = 1;
    const Status status = team.sum({&number, 1});
    ASSERT_FALSE(status);
    EXPECT_EQ(status.error().message, "rank 1: no such file");
  });
}

TEST(Team, CancelledRanksGiveWayToTheReason) {
  onRanks(2, [](Team& team) {
    const Status own =
        team.rank() == 0 ? fail(ErrorCode::kCancelled, "stopped") : fail(ErrorCode::kIo, "broken");
    EXPECT_EQ(team.agree(own).error().message, "rank 1: broken");
  });
}

TEST(Team, CollectsInAnyOrder) {
  onRanks(3, [](Team& team) {
    Progress progress;
    ASSERT_TRUE(team.forUnits("send", 12, progress, [&](std::int64_t unit) {
      return team.post(unit, std::vector<std::byte>(100, std::byte(unit)), 1 << 20);
    }));
    if (team.leads()) {
      for (std::int64_t unit = 12; unit-- > 0;) {
        const auto bytes = team.collect(unit);
        ASSERT_TRUE(bytes);
        EXPECT_EQ(*bytes, std::vector<std::byte>(100, std::byte(unit)));
      }
    }
    ASSERT_TRUE(team.agree({}));
  });
}

TEST(Team, WhoWaitsForARankThatFailedIsTold) {
  onRanks(2, [](Team& team) {
    if (team.leads()) {
      const auto bytes = team.collect(5);
      ASSERT_FALSE(bytes);
      EXPECT_EQ(team.agree(tl::unexpected<Error>(bytes.error())).error().message, "rank 1: broken");
    } else {
      EXPECT_FALSE(team.agree(fail(ErrorCode::kIo, "broken")));
    }
  });
}

// Without `last` rank 0 would wait for ranks that wait for it.
TEST(Team, SendersWaitForRoom) {
  onRanks(3, [](Team& team) {
    Progress progress;
    std::int64_t next = 0;
    const auto collectAll = [&]() -> Status {
      for (; team.leads() && next < 50; ++next) VOLUTE_TRY(team.collect(next));
      return {};
    };
    const auto send = [&](std::int64_t unit) {
      return team.post(unit, std::vector<std::byte>(1000), 2500);
    };
    ASSERT_TRUE(team.forUnits("send", 50, progress, send, collectAll));
    EXPECT_EQ(next, team.leads() ? 50 : 0);
  });
}

TEST(OrderedDelivery, GivesUnitsInOrder) {
  for (const int ranks : {1, 2, 5}) {
    onRanks(ranks, [](Team& team) {
      Progress progress;
      std::vector<std::int64_t> taken;
      OrderedDelivery delivery(team, 40, 250, [&](std::int64_t unit, const auto& bytes) -> Status {
        EXPECT_EQ(bytes, std::vector<std::byte>(100, std::byte(unit)));
        taken.push_back(unit);
        return {};
      });
      // One that rank 0 had before all others, as the picture that the exposure is found from.
      if (team.leads()) {
        ASSERT_TRUE(delivery.give(20, std::vector<std::byte>(100, std::byte(20))));
      }
      ASSERT_TRUE(team.forUnits(
          "work", 40, progress,
          [&](std::int64_t unit) -> Status {
            if (unit == 20)
              return {};
            return delivery.give(unit, std::vector<std::byte>(100, std::byte(unit)));
          },
          [&] { return delivery.finish(); }));
      std::vector<std::int64_t> all(team.leads() ? 40 : 0);
      for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::int64_t>(i);
      EXPECT_EQ(taken, all);
    });
  }
}

TEST(OrderedDelivery, AnErrorOfTheTakerEndsAll) {
  onRanks(3, [](Team& team) {
    Progress progress;
    OrderedDelivery delivery(team, 40, 250, [&](std::int64_t unit, const auto&) -> Status {
      return unit == 11 ? Status(fail(ErrorCode::kIo, "the disk is full")) : Status();
    });
    const Status status = team.forUnits(
        "work", 40, progress,
        [&](std::int64_t unit) { return delivery.give(unit, std::vector<std::byte>(100)); },
        [&] { return delivery.finish(); });
    ASSERT_FALSE(status);
    EXPECT_EQ(status.error().message, "the disk is full");
  });
}

TEST(Team, AnErrorKeepsItsSettingAndHints) {
  Team team;
  const Status failed = failFor("bounds", ErrorCode::kTooLarge,
                                Hint::raise("max_memory").so("holds all"), "it is large");
  const Error agreed = team.agree(failed).error();
  EXPECT_EQ(agreed.code, ErrorCode::kTooLarge);
  EXPECT_EQ(agreed.message, "it is large");
  EXPECT_EQ(agreed.member, "bounds");
  EXPECT_EQ(agreed.hints, failed.error().hints);
}

}  // namespace
}  // namespace volute
