// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/snapshot_ring.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace volute {
namespace {

using ::testing::Optional;

constexpr std::uint64_t kMega = 1 << 20;

SnapshotRing::Held snapshot(std::uint64_t bytes = kMega) {
  return std::make_shared<const ViewScene>(ViewScene{.bytes = bytes});
}

TEST(SnapshotRing, GivesWhatWasAdded) {
  SnapshotRing ring;
  const auto one = snapshot();
  EXPECT_TRUE(ring.add(0.5, one, {}).empty());
  EXPECT_EQ(ring.find(0.5), one);
  EXPECT_EQ(ring.find(0.25), nullptr);
  const auto other = snapshot();
  EXPECT_THAT(ring.add(0.5, other, {}), ::testing::ElementsAre(one));
  EXPECT_EQ(ring.find(0.5), other);
  EXPECT_EQ(ring.size(), 1);
}

TEST(SnapshotRing, KeepsWhatIsWantedNextAndDropsTheRestFirst) {
  SnapshotRing ring;
  ring.setLimit(4 * kMega);
  const double ahead[] = {3, 4, 0};
  for (const double time : {0.0, 1.0, 2.0}) ring.add(time, snapshot(), {});
  EXPECT_EQ(ring.size(), 3);
  ring.add(3, snapshot(), ahead);
  EXPECT_EQ(ring.size(), 3) << "each has some bytes besides";
  EXPECT_NE(ring.find(0), nullptr) << "it is wanted again";
  EXPECT_EQ(ring.find(1), nullptr);
  ring.add(4, snapshot(), ahead);
  EXPECT_EQ(ring.find(2), nullptr);
  EXPECT_NE(ring.find(0), nullptr);
  EXPECT_LE(ring.bytes(), 4 * kMega);
}

TEST(SnapshotRing, DropsTheFarthestOfWhatIsWantedWhereThatIsTooMuch) {
  SnapshotRing ring;
  ring.setLimit(2 * kMega + kMega / 2);
  const double ahead[] = {0, 1, 2, 3};
  for (const double time : ahead) ring.add(time, snapshot(), ahead);
  EXPECT_LE(ring.bytes(), 3 * kMega);
  EXPECT_NE(ring.find(0), nullptr);
  EXPECT_NE(ring.find(3), nullptr) << "the newest stays: it is to be shown";
  EXPECT_EQ(ring.find(2), nullptr);
}

TEST(SnapshotRing, SaysWhatIsMissingWhileThereIsRoom) {
  SnapshotRing ring;
  ring.setLimit(3 * kMega);
  const double ahead[] = {1, 2, 3, 4, 5};
  EXPECT_THAT(ring.missing(ahead), Optional(1.0));
  ring.add(1, snapshot(), ahead);
  EXPECT_THAT(ring.missing(ahead), Optional(2.0));
  ring.add(2, snapshot(), ahead);
  EXPECT_EQ(ring.missing(ahead), std::nullopt) << "a third one is too much, with what each costs";
  EXPECT_EQ(ring.missing({}), std::nullopt);
}

TEST(SnapshotRing, HoldsOneThatIsLargerThanItMayBe) {
  SnapshotRing ring;
  ring.setLimit(kMega);
  ring.add(0, snapshot(8 * kMega), {});
  EXPECT_NE(ring.find(0), nullptr);
  EXPECT_EQ(ring.add(1, snapshot(8 * kMega), {}).size(), 1);
  EXPECT_EQ(ring.clear().size(), 1);
  EXPECT_EQ(ring.bytes(), 0);
}

}  // namespace
}  // namespace volute
