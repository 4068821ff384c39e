// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/volume/transfer.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace volute {
namespace {

using Json = nlohmann::ordered_json;
using ::testing::HasSubstr;

TEST(Transfer, IsLinearBetweenItsPointsAndConstantBeyond) {
  const Transfer transfer{.least = 0, .most = 10, .points = {{2, 1}, {4, 5}, {4, 2}, {6, 0}}};
  EXPECT_EQ(transfer.extinctionOf(-7), 1);
  EXPECT_EQ(transfer.extinctionOf(3), 3);
  EXPECT_EQ(transfer.extinctionOf(4), 2) << "after the step";
  EXPECT_EQ(transfer.extinctionOf(5), 1);
  EXPECT_EQ(transfer.extinctionOf(1e30), 0);
}

TEST(Transfer, WhatCannotBeReadIsNamed) {
  const auto message = [](const char* text) {
    const auto read =
        readAs<Transfer>(transferFields(), nlohmann::json::parse(text), {"a.json", "/transfer"});
    return read ? std::string("no error") : read.error().message;
  };
  EXPECT_EQ(message(R"({"map": "plasma", "range": [-1, 2], "points": [[0, 1], [1, 2]]})"),
            "no error");
  EXPECT_THAT(message(R"({"map": "jet"})"), HasSubstr("/transfer/map"));
  EXPECT_THAT(message(R"({"range": [2, 1]})"), HasSubstr("/transfer/range"));
  EXPECT_THAT(message(R"({"points": [[1, 0], [0, 1]]})"), HasSubstr("ascending"));
  EXPECT_THAT(message(R"({"points": [[1, 0]]})"), HasSubstr("two points"));
  EXPECT_THAT(message(R"({"points": [[1, 0], [2, -1]]})"), HasSubstr("out of range"));
}

TEST(Transfer, IsSetByItsControls) {
  const ValueCounts values{.least = 20, .most = 420, .counts = {1, 2}};
  Json volume = Json::object();
  ASSERT_TRUE(setTransfer(volume, "transfer/map", "inferno", {1}, values, 4));
  EXPECT_EQ(volume["transfer"]["range"], Json({20, 420}));
  EXPECT_EQ(volume["transfer"]["points"].size(), 3);
  EXPECT_TRUE(readAs<Transfer>(transferFields(), nlohmann::json(volume["transfer"]), {}));
  ASSERT_TRUE(setTransfer(volume, "transfer/points/1", "", {9000, 0.5}, values, 4));
  EXPECT_EQ(volume["transfer"]["points"][1], Json({420, 0.5})) << "not beyond the next point";
  ASSERT_TRUE(setTransfer(volume, "transfer/range/0", "", {500}, values, 4));
  EXPECT_LT(volume["transfer"]["range"][0].get<double>(), 420) << "not beyond the last colour";
  const auto added = editTransfer(volume, "transfer/points/0", true);
  ASSERT_TRUE(added && *added);
  EXPECT_EQ(volume["transfer"]["points"].size(), 4);
  for (int i = 0; i < 2; ++i) ASSERT_TRUE(editTransfer(volume, "transfer/points/0", false));
  EXPECT_FALSE(editTransfer(volume, "transfer/points/0", false)) << "two stay";
  ASSERT_TRUE(setTransfer(volume, "transfer/map", "off", {0}, values, 4));
  EXPECT_FALSE(volume.contains("transfer"));
  EXPECT_FALSE(setTransfer(volume, "emission", "", {0}, values, 4));
}

TEST(Transfer, ValuesAreCountedWhereSomethingIsStored) {
  VolumeInfo info;
  info.x = info.y = info.z = 9;
  info.fillDefaults();
  std::vector<float> values(info.frameValues(), 2);
  values[0] = -6, values[1] = 10;
  const ValueCounts counted = ValueCounts::of(BrickSlice::fromDense(info, values));
  EXPECT_EQ(counted.least, -6);
  EXPECT_EQ(counted.most, 10);
  EXPECT_EQ(counted.counts[32], 9 * 9 * 9 - 2);
  EXPECT_EQ(counted.counts.front(), 1);
  EXPECT_EQ(counted.counts.back(), 1);
}

}  // namespace
}  // namespace volute
