// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/number_type.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

namespace volute {
namespace {

constexpr bool kBig = std::endian::native == std::endian::big;

/// Of numbers in memory, each `stride` bytes after the one before.
template <class T>
std::vector<std::byte> laidOut(const std::vector<T>& numbers, std::size_t stride, bool swap) {
  std::vector<std::byte> bytes(numbers.size() * stride + sizeof(T));
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    std::array<std::byte, sizeof(T)> one;
    std::memcpy(one.data(), &numbers[i], sizeof(T));
    if (swap)
      std::ranges::reverse(one);
    std::ranges::copy(one, bytes.begin() + static_cast<std::ptrdiff_t>(i * stride));
  }
  return bytes;
}

/// Any numbers of a type, with any stride and order of bytes: the nearest floats, and the largest
/// difference is the true one.
template <class T>
void checkType(NumberKind kind) {
  const auto bits =
      *rc::gen::container<std::vector<std::uint64_t>>(rc::gen::arbitrary<std::uint64_t>());
  std::vector<T> numbers;
  for (const std::uint64_t number : bits) {
    T one;
    std::memcpy(&one, &number, sizeof one);
    if constexpr (std::is_floating_point_v<T>) {
      if (!(std::abs(one) < T(3e38)))
        one = T(0.1);
    }
    numbers.push_back(one);
  }
  const std::size_t stride = sizeof(T) + *rc::gen::inRange<std::size_t>(0, 9);
  const bool swap = *rc::gen::arbitrary<bool>();
  const auto bytes = laidOut(numbers, stride, swap);
  std::vector<float> values(numbers.size());
  double rounding = 0;
  const NumberType type{kind, swap != kBig};
  RC_ASSERT(type.size() == sizeof(T));
  RC_ASSERT(!toFloats(type, bytes.data(), static_cast<std::ptrdiff_t>(stride), values, rounding));
  long double most = 0;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    RC_ASSERT(values[i] == static_cast<float>(numbers[i]));
    most = std::max(most, std::abs(static_cast<long double>(numbers[i]) - values[i]));
  }
  RC_ASSERT(rounding == static_cast<double>(most));
}

RC_GTEST_PROP(NumberType, EveryTypeBecomesTheNearestFloat, ()) {
  checkType<std::uint8_t>(NumberKind::kUint8);
  checkType<std::int16_t>(NumberKind::kInt16);
  checkType<std::uint32_t>(NumberKind::kUint32);
  checkType<std::int32_t>(NumberKind::kInt32);
  checkType<std::uint64_t>(NumberKind::kUint64);
  checkType<std::int64_t>(NumberKind::kInt64);
  checkType<float>(NumberKind::kFloat32);
  checkType<double>(NumberKind::kFloat64);
}

TEST(NumberType, HalvesAndTruthValues) {
  std::vector<float> values(3);
  double rounding = 0;
  const auto halves = laidOut<std::uint16_t>({0x3C00, 0xC000, 0x0001}, 2, true);
  EXPECT_FALSE(toFloats({NumberKind::kFloat16, !kBig}, halves.data(), 2, values, rounding));
  EXPECT_EQ(values, (std::vector<float>{1, -2, 0x1p-24F}));
  const auto truths = laidOut<std::uint8_t>({1, 0, 255}, 1, false);
  EXPECT_FALSE(toFloats({NumberKind::kBool}, truths.data(), 1, values, rounding));
  EXPECT_EQ(values, (std::vector<float>{1, 0, 1}));
  EXPECT_EQ(rounding, 0);
}

TEST(NumberType, NumbersBeyondFloatsAreNamedAndInfinitiesKept) {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  std::vector<float> values(3);
  double rounding = 0;
  auto bytes = laidOut<double>({kInf, 1, -kInf}, 8, false);
  EXPECT_FALSE(toFloats({NumberKind::kFloat64, kBig}, bytes.data(), 8, values, rounding));
  EXPECT_TRUE(std::isinf(values[0]) && std::isinf(values[2]));
  EXPECT_EQ(rounding, 0);
  bytes = laidOut<double>({1, -1e300, 2}, 8, false);
  EXPECT_EQ(toFloats({NumberKind::kFloat64, kBig}, bytes.data(), 8, values, rounding), -1e300);
}

TEST(NumberType, CodesOfNumPy) {
  EXPECT_EQ(numberTypeOf("<f8"), (NumberType{NumberKind::kFloat64, false}));
  EXPECT_EQ(numberTypeOf(">i2"), (NumberType{NumberKind::kInt16, true}));
  EXPECT_EQ(numberTypeOf("=u4"), (NumberType{NumberKind::kUint32, kBig}));
  EXPECT_EQ(numberTypeOf("|u1"), (NumberType{NumberKind::kUint8, false}));
  EXPECT_EQ(numberTypeOf("|b1"), (NumberType{NumberKind::kBool, false}));
  EXPECT_TRUE(numberTypeOf("<f4")->isFloat() != kBig);
  for (const char* code : {"<c8", "<f16", "|O", "<U3", "f4", "|f4", "<f3", "", "<M8[s]"})
    EXPECT_FALSE(numberTypeOf(code)) << code;
}

}  // namespace
}  // namespace volute
