// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/volume_files/memory_volumes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <vector>

#include "volute/grid/sequence.hpp"
#include "volute/volume_files/volume_input.hpp"

namespace volute {
namespace {

using ::testing::HasSubstr;

TEST(MemoryVolumes, AreOpenedByTheirNamesAsFilesAre) {
  const std::vector<double> numbers{1, 2, 3, 4, 5, 6, 7, 8};
  const NumberType doubles{NumberKind::kFloat64, std::endian::native == std::endian::big};
  VolumeInfo info = makeSequence(2, 1, 2, 2).info;
  info.name = "heat";
  MemoryVolumes volumes;
  const NumberArray array{reinterpret_cast<const std::byte*>(numbers.data()), doubles,
                          denseStrides(info, doubles)};
  ASSERT_TRUE(volumes.add("a", info, array).has_value());
  EXPECT_THAT(volumes.add("a/b", info, array).error().message, HasSubstr("without '/'"));
  VolumeInfo empty = info;
  empty.x = 0;
  EXPECT_FALSE(volumes.add("b", empty, array).has_value());

  Progress quiet;
  Reading reading{quiet, std::uint64_t{1} << 30, &volumes};
  auto input = openVolume("folder/memory:a", {}, reading);
  ASSERT_TRUE(input.has_value()) << input.error().message;
  std::vector<float> frame(4);
  ASSERT_TRUE(input->source->readFrame(1, frame).has_value());
  EXPECT_EQ(frame, (std::vector<float>{5, 6, 7, 8}));
  InputOptions other;
  other.grid = "soot";
  EXPECT_THAT(openVolume("memory:a", other, reading).error().message, HasSubstr("holds 'heat'"));
  other.grid = "heat";
  EXPECT_TRUE(openVolume("memory:a", other, reading).has_value());
  other.bounds = Box3{Vec3::Zero(), Vec3::Ones()};
  EXPECT_THAT(openVolume("memory:a", other, reading).error().message, HasSubstr("its bounds"));
  // What is not there is looked for among files.
  EXPECT_FALSE(openVolume("memory:c", {}, reading).has_value());
  EXPECT_TRUE(MemoryVolumes::isName("x/memory:c") && !MemoryVolumes::isName("c.npy"));
}

TEST(MemoryVolumes, FunctionsAreVolumes) {
  VolumeInfo info = makeSequence(2, 4, 4, 4).info;
  info.name = "heat";
  MemoryVolumes volumes;
  ASSERT_TRUE(volumes.add("f", info, [](const PlacesAtTime& at, std::span<float> values) -> Status {
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] = static_cast<float>(at.x[i] + at.time);
    return {};
  }));
  MemoryVolumes others;
  others.add(volumes);
  Progress quiet;
  Reading reading{quiet, std::uint64_t{1} << 30, &others};
  auto input = openVolume("memory:f", {}, reading);
  ASSERT_TRUE(input.has_value()) << input.error().message;
  std::vector<float> frame(64);
  ASSERT_TRUE(input->source->readFrame(1, frame).has_value());
  const double first = info.bounds.min.x() + 0.5 * info.voxelSize().x() + info.times[1];
  EXPECT_FLOAT_EQ(frame[0], static_cast<float>(first));
}

TEST(MemoryVolumes, EndlessFramesAreRefusedBeforeTheyTakeMemory) {
  VolumeInfo info;
  info.frames = 1'000'000'000;
  info.x = info.y = info.z = 10;
  info.fillDefaults();
  EXPECT_TRUE(info.times.empty());
  MemoryVolumes volumes;
  const Status status = volumes.add("a", info, NumberArray{});
  EXPECT_EQ(status.error().code, ErrorCode::kTooLarge);
  EXPECT_THAT(status.error().message, HasSubstr("1000000000 frames; expected at most"));
}

}  // namespace
}  // namespace volute
