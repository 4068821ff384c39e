// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/raw_volume.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "volute/io/sequence_testing.hpp"
#include "volute/io/testing.hpp"

namespace volute {
namespace {

using ::testing::HasSubstr;
using namespace testing;
using Type = RawLayout::Type;

template <class Value>
std::string bytesOf(std::initializer_list<Value> values, bool big = false) {
  std::string bytes;
  for (const Value value : values) {
    char one[sizeof value];
    std::memcpy(one, &value, sizeof value);
    if (big)
      std::reverse(one, one + sizeof value);
    bytes.append(one, sizeof value);
  }
  return bytes;
}

SourceOptions rawOptions(std::array<int, 3> size, Type type, int channels = 1) {
  SourceOptions options;
  options.raw = RawLayout{size, channels, type, false, 0};
  return options;
}

TEST(Raw, AllTypesInBothOrders) {
  struct Case {
    Type type;
    std::string little, big;
    std::vector<float> values;
  };

  const Case cases[] = {
      {Type::kUint8, bytesOf<std::uint8_t>({0, 255}), bytesOf<std::uint8_t>({0, 255}), {0, 255}},
      {Type::kInt8, bytesOf<std::int8_t>({-128, 7}), bytesOf<std::int8_t>({-128, 7}), {-128, 7}},
      {Type::kUint16,
       bytesOf<std::uint16_t>({1, 65535}),
       bytesOf<std::uint16_t>({1, 65535}, true),
       {1, 65535}},
      {Type::kInt16,
       bytesOf<std::int16_t>({-2, 300}),
       bytesOf<std::int16_t>({-2, 300}, true),
       {-2, 300}},
      {Type::kUint32,
       bytesOf<std::uint32_t>({1, 1u << 31}),
       bytesOf<std::uint32_t>({1, 1u << 31}, true),
       {1, 0x1p31f}},
      {Type::kInt32,
       bytesOf<std::int32_t>({-70000, 3}),
       bytesOf<std::int32_t>({-70000, 3}, true),
       {-70000, 3}},
      {Type::kFloat16,
       bytesOf<std::uint16_t>({0x3C00, 0xC000}),
       bytesOf<std::uint16_t>({0x3C00, 0xC000}, true),
       {1, -2}},
      {Type::kFloat32,
       bytesOf<float>({1.25f, -3e30f}),
       bytesOf<float>({1.25f, -3e30f}, true),
       {1.25f, -3e30f}},
      {Type::kFloat64, bytesOf<double>({0.1, -2}), bytesOf<double>({0.1, -2}, true), {0.1f, -2}}};
  for (const Case& one : cases) {
    const TempFolder folder;
    SourceOptions options = rawOptions({2, 1, 1}, one.type);
    options.raw->offset = 3;
    for (const bool big : {false, true}) {
      options.raw->bigEndian = big;
      writeBytes(folder / "a.raw", "abc" + (big ? one.big : one.little));
      ASSERT_VALUE(const auto read, readSequence(folder / "a.raw", options));
      EXPECT_EQ(read.values, one.values) << static_cast<int>(one.type) << big;
    }
  }
}

TEST(Raw, LayersOfAFileAndOfNumberedOnesAreThoseOfTheFrame) {
  const TempFolder folder;
  const auto written = testing::makeBlob(3, 5, 4, 3, 3);
  std::string all = "header";
  for (int i = 0; i < 3; ++i) {
    const auto frame = std::as_bytes(written.frame(i));
    const std::string bytes(reinterpret_cast<const char*>(frame.data()), frame.size());
    writeBytes(folder / ("f_" + std::to_string(7 + 2 * i) + ".dat"), "header" + bytes);
    all += bytes;
  }
  writeBytes(folder / "all.bin", all);
  SourceOptions options = rawOptions({3, 4, 5}, Type::kFloat32, 3);
  options.raw->offset = 6;
  options.byLayers = true;
  options.maxMemory = 100;  // less than a frame
  for (const char* name : {"all.bin", "f_%d.dat"}) {
    ASSERT_VALUE(const auto source, openSource(folder / name, options));
    EXPECT_EQ(source->info().frames, 3);
    EXPECT_EQ(source->info().frameNumbers.back(), name[0] == 'f' ? 11 : 2);
    ASSERT_TRUE(source->readsLayers());
    std::vector<float> part(2 * 4 * 3 * 3);
    ASSERT_TRUE(ok(source->readLayers(2, 3, 5, part)));
    const auto frame = written.frame(2);
    EXPECT_TRUE(std::equal(part.begin(), part.end(),
                           frame.end() - static_cast<std::ptrdiff_t>(part.size())));
  }
}

TEST(Raw, AFileOfAnotherLengthIsRefused) {
  const TempFolder folder;
  const SourceOptions options = rawOptions({4, 3, 2}, Type::kInt16);
  for (const std::size_t bytes : {0u, 47u, 49u, 95u}) {
    writeBytes(folder / "a.raw", std::string(bytes, 'x'));
    const auto read = openSource(folder / "a.raw", options);
    ASSERT_FALSE(read) << bytes;
    EXPECT_THAT(read.error().message, HasSubstr("a.raw: has"));
    EXPECT_THAT(read.error().message, HasSubstr("expected a whole number of them"));
  }
  writeBytes(folder / "f_1.raw", std::string(48, 'x'));
  writeBytes(folder / "f_2.raw", std::string(96, 'x'));
  const auto read = openSource(folder / "f_%d.raw", options);
  ASSERT_FALSE(read);
  EXPECT_THAT(read.error().message, HasSubstr("expected one of them and nothing else"));
}

TEST(Raw, SizesThatOverflowAreRefused) {
  const TempFolder folder;
  writeBytes(folder / "a.raw", "12345678");
  for (const std::array<int, 3> size :
       {std::array{2000000000, 2000000000, 2000000000}, std::array{0, 1, 1}, std::array{-1, 1, 1}})
    EXPECT_FALSE(openSource(folder / "a.raw", rawOptions(size, Type::kFloat64)));
}

}  // namespace
}  // namespace volute
