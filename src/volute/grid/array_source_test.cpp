// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/array_source.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <numeric>

#include "volute/grid/sequence.hpp"

namespace volute {
namespace {

constexpr bool kBig = std::endian::native == std::endian::big;

// Numbers laid out with their axes in any order, forwards or backwards, with gaps.
RC_GTEST_PROP(ArraySource, ReadsNumbersInAnyLayout, ()) {
  const auto side = rc::gen::inRange(1, 5);
  Sequence expected = makeSequence(*side, *side, *side, *side, *rc::gen::element(1, 3));
  const VolumeInfo& info = expected.info;
  const std::array<std::ptrdiff_t, 5> sides{info.frames, info.z, info.y, info.x, info.channels};
  std::array<std::size_t, 5> order{0, 1, 2, 3, 4};
  for (std::size_t i = 5; i > 1; --i)
    std::swap(order[i - 1], order[*rc::gen::inRange<std::size_t>(0, i)]);
  std::array<std::ptrdiff_t, 5> strides{};
  std::ptrdiff_t reach = 8, first = 0;
  for (const std::size_t axis : order) {
    strides[axis] = reach + *rc::gen::inRange(0, 3);
    reach = strides[axis] * sides[axis];
    if (*rc::gen::arbitrary<bool>()) {
      first += strides[axis] * (sides[axis] - 1);
      strides[axis] = -strides[axis];
    }
  }
  std::vector<std::byte> memory(static_cast<std::size_t>(reach + 16));
  double most = 0;
  std::size_t number = 0;
  for (std::ptrdiff_t t = 0; t < sides[0]; ++t)
    for (std::ptrdiff_t z = 0; z < sides[1]; ++z)
      for (std::ptrdiff_t y = 0; y < sides[2]; ++y)
        for (std::ptrdiff_t x = 0; x < sides[3]; ++x)
          for (std::ptrdiff_t c = 0; c < sides[4]; ++c) {
            const double value = 1e5 + 0.1 * static_cast<double>(number);
            const std::ptrdiff_t at = first + t * strides[0] + z * strides[1] + y * strides[2] +
                                      x * strides[3] + c * strides[4];
            std::memcpy(memory.data() + at, &value, sizeof value);
            expected.values[number++] = static_cast<float>(value);
            most = std::max(most, std::abs(value - static_cast<double>(static_cast<float>(value))));
          }
  ArraySource source(info, {memory.data() + first, {NumberKind::kFloat64, kBig}, strides});
  const auto read = readAll(source, 1 << 20);
  RC_ASSERT(read.has_value());
  RC_ASSERT(read->values == expected.values);
  RC_ASSERT(source.rounding() == most);
  std::vector<float> layer(info.frameValues() / static_cast<std::size_t>(info.z));
  RC_ASSERT(source.readLayers(info.frames - 1, info.z - 1, info.z, layer).has_value());
  RC_ASSERT(std::equal(layer.begin(), layer.end(),
                       expected.values.end() - static_cast<std::ptrdiff_t>(layer.size())));
}

TEST(ArraySource, NumbersBeyondFloatsAreRefused) {
  const std::vector<double> numbers{1, 2, 1e39, 4};
  const Sequence shape = makeSequence(2, 1, 1, 2);
  const NumberType doubles{NumberKind::kFloat64, kBig};
  ArraySource source(shape.info, {reinterpret_cast<const std::byte*>(numbers.data()), doubles,
                                  denseStrides(shape.info, doubles)});
  std::vector<float> frame(2);
  EXPECT_TRUE(source.readFrame(0, frame).has_value());
  EXPECT_THAT(source.readFrame(1, frame).error().message,
              ::testing::HasSubstr("frame 1: the value 1e+39"));
}

}  // namespace
}  // namespace volute
