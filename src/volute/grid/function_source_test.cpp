// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/function_source.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace volute {
namespace {

using testing::HasSubstr;

VolumeInfo functionInfo(int side, int channels = 1) {
  VolumeInfo info;
  info.frames = 2;
  info.x = side, info.y = side, info.z = side;
  info.channels = channels;
  info.fillDefaults();
  info.bounds = {Vec3(0, 0, -1), Vec3(side, 2.0 * side, side - 1)};
  info.times = {0.5, 2};
  return info;
}

TEST(FunctionSource, AsksAtCentresOfVoxelsAndTimesOfFrames) {
  FunctionSource source(functionInfo(4, 3), [](const PlacesAtTime& at, std::span<float> values) {
    for (std::size_t i = 0; i < at.x.size(); ++i) {
      values[3 * i] = static_cast<float>(at.x[i]);
      values[3 * i + 1] = static_cast<float>(at.y[i]);
      values[3 * i + 2] = static_cast<float>(at.z[i] + 100 * at.time);
    }
    return Status{};
  });
  std::vector<float> frame(source.info().frameValues());
  ASSERT_TRUE(source.readFrame(1, frame));
  const auto at = [&](int z, int y, int x, int c) { return frame[((z * 4 + y) * 4 + x) * 3 + c]; };
  EXPECT_FLOAT_EQ(at(0, 0, 0, 0), 0.5F);
  EXPECT_FLOAT_EQ(at(1, 2, 3, 0), 3.5F);
  EXPECT_FLOAT_EQ(at(1, 2, 3, 1), 5);
  EXPECT_FLOAT_EQ(at(3, 2, 1, 2), 202.5F);
}

TEST(FunctionSource, BatchesAreLargeAndLayersAreThoseOfTheFrame) {
  std::vector<std::size_t> batches;
  FunctionSource source(functionInfo(40), [&](const PlacesAtTime& at, std::span<float> values) {
    batches.push_back(at.x.size());
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] = static_cast<float>(at.x[i] + 7 * at.y[i] + 31 * at.z[i]);
    return Status{};
  });
  ASSERT_TRUE(source.readsLayers());
  std::vector<float> frame(source.info().frameValues()), layers(3 * 1600);
  ASSERT_TRUE(source.readFrame(0, frame));
  EXPECT_EQ(batches, (std::vector<std::size_t>{1 << 15, 64000 - (1 << 15)}));
  ASSERT_TRUE(source.readLayers(0, 5, 8, layers));
  EXPECT_TRUE(std::ranges::equal(layers, std::span(frame).subspan(5 * 1600, layers.size())));
  EXPECT_FALSE(FunctionSource(functionInfo(8), {}).readsLayers());
}

TEST(FunctionSource, ErrorsAreTheFunctionsAndValuesAreFinite) {
  FunctionSource stops(functionInfo(4), [](const PlacesAtTime&, std::span<float>) -> Status {
    return fail(ErrorCode::kCancelled, "enough");
  });
  std::vector<float> frame(64);
  EXPECT_EQ(stops.readFrame(0, frame).error().message, "enough");
  FunctionSource wrong(functionInfo(4), [](const PlacesAtTime&, std::span<float> values) {
    std::ranges::fill(values, 1.0F);
    values[5] = std::numeric_limits<float>::quiet_NaN();
    return Status{};
  });
  const Status status = wrong.readFrame(0, frame);
  EXPECT_EQ(status.error().code, ErrorCode::kInvalidData);
  EXPECT_THAT(status.error().message, HasSubstr("is nan at (1.5, 3, -0.5) m, 0.5 s"));
}

}  // namespace
}  // namespace volute
