// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/wavelet/shape_adaptive.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <cstring>
#include <random>
#include <vector>

#include "volute/wavelet/transform4d.hpp"

namespace volute {
namespace {

using Extents = std::array<int, 4>;
constexpr Wavelet kWavelets[] = {Wavelet::kHaar, Wavelet::kCdf53, Wavelet::kCdf97};

std::size_t sizeOf(const Extents& e) {
  return static_cast<std::size_t>(e[0]) * e[1] * e[2] * e[3];
}

struct Shaped {
  std::vector<float> samples;
  std::vector<std::uint8_t> support;
};

Shaped randomShape(std::size_t size, double share, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> value(-1, 1);
  std::bernoulli_distribution in(share);
  Shaped shaped{std::vector<float>(size), std::vector<std::uint8_t>(size)};
  for (std::size_t i = 0; i < size; ++i) {
    shaped.support[i] = in(random) ? 1 : 0;
    shaped.samples[i] = shaped.support[i] != 0 ? value(random) : 0;
  }
  return shaped;
}

// Each pass of the block transform, line by line, with the line twin.
void slowTransform(std::vector<float>& x, const std::vector<std::uint8_t>& support,
                   const Extents& e, Wavelet wavelet, const AxisLevels& levels) {
  const std::array<std::ptrdiff_t, 4> strides{std::ptrdiff_t{e[1]} * e[2] * e[3],
                                              std::ptrdiff_t{e[2]} * e[3], e[3], 1};
  for (int level = 0; level < deepest(levels); ++level) {
    for (int axis = 4; axis-- > 0;) {
      if (level >= levels[axis])
        continue;
      Extents steps{}, begin{};
      for (int a = 0; a < 4; ++a) steps[a] = 1 << std::min(level, levels[a]);
      for (begin[0] = 0; begin[0] < (axis == 0 ? 1 : e[0]); begin[0] += steps[0])
        for (begin[1] = 0; begin[1] < (axis == 1 ? 1 : e[1]); begin[1] += steps[1])
          for (begin[2] = 0; begin[2] < (axis == 2 ? 1 : e[2]); begin[2] += steps[2])
            for (begin[3] = 0; begin[3] < (axis == 3 ? 1 : e[3]); begin[3] += steps[3]) {
              std::ptrdiff_t first = 0;
              for (int a = 0; a < 4; ++a) first += begin[a] * strides[a];
              const int count = (e[axis] + steps[axis] - 1) / steps[axis];
              std::vector<float> line(count);
              std::vector<std::uint8_t> in(count);
              for (int i = 0; i < count; ++i) {
                line[i] = x[first + i * steps[axis] * strides[axis]];
                in[i] = support[first + i * steps[axis] * strides[axis]];
              }
              shapeForwardLine(line, in, wavelet);
              for (int i = 0; i < count; ++i) x[first + i * steps[axis] * strides[axis]] = line[i];
            }
    }
  }
}

TEST(ShapeAdaptive, FullSupportIsTheSymmetricTransform) {
  const Extents e{16, 13, 7, 10};
  const auto shaped = randomShape(sizeOf(e), 1, 1);
  for (Wavelet wavelet : kWavelets) {
    const AxisLevels levels = blockLevels(e, 3);
    auto fast = shaped.samples;
    shapeForward(fast, {}, e, wavelet, levels);
    auto slow = shaped.samples;
    const View<float, 4> view(std::span<float>(slow), {e[0], e[1], e[2], e[3]});
    transformForward(view, wavelet, {levels[0], levels[1], levels[2], levels[3]});
    for (std::size_t i = 0; i < fast.size(); ++i) ASSERT_NEAR(fast[i], slow[i], 2e-5);
  }
}

TEST(ShapeAdaptive, NoSupportGivenMeansAll) {
  const Extents e{8, 16, 16, 5};
  const auto shaped = randomShape(sizeOf(e), 1, 2);
  for (Wavelet wavelet : kWavelets) {
    auto all = shaped.samples;
    auto none = shaped.samples;
    shapeForward(all, shaped.support, e, wavelet, blockLevels(e, 4));
    shapeForward(none, {}, e, wavelet, blockLevels(e, 4));
    EXPECT_EQ(all, none);
  }
}

// The same bits, not just close: files depend on it.
RC_GTEST_PROP(ShapeAdaptive, FastIsTheLineTwin, ()) {
  const Extents e{*rc::gen::inRange(1, 17), *rc::gen::inRange(1, 17), *rc::gen::inRange(1, 17),
                  *rc::gen::inRange(1, 17)};
  const Wavelet wavelet = kWavelets[*rc::gen::inRange(0, 3)];
  const AxisLevels levels = blockLevels(e, *rc::gen::element(0, 1, 2, 4));
  const auto shaped = randomShape(sizeOf(e), *rc::gen::element(0.1, 0.5, 0.9, 1.0),
                                  *rc::gen::arbitrary<unsigned>());
  auto fast = shaped.samples;
  shapeForward(fast, shaped.support, e, wavelet, levels);
  auto slow = shaped.samples;
  slowTransform(slow, shaped.support, e, wavelet, levels);
  for (std::size_t i = 0; i < fast.size(); ++i) RC_ASSERT(fast[i] == slow[i]);
}

RC_GTEST_PROP(ShapeAdaptive, InverseRestores, ()) {
  const Extents e{*rc::gen::inRange(1, 17), *rc::gen::inRange(1, 17), *rc::gen::inRange(1, 17),
                  *rc::gen::inRange(1, 17)};
  const Wavelet wavelet = kWavelets[*rc::gen::inRange(0, 3)];
  const AxisLevels levels = blockLevels(e, *rc::gen::element(0, 1, 2, 4));
  const auto shaped = randomShape(sizeOf(e), *rc::gen::element(0.05, 0.4, 0.95, 1.0),
                                  *rc::gen::arbitrary<unsigned>());
  auto x = shaped.samples;
  shapeForward(x, shaped.support, e, wavelet, levels);
  for (std::size_t i = 0; i < x.size(); ++i) RC_ASSERT(shaped.support[i] != 0 || x[i] == 0);
  shapeInverse(x, shaped.support, e, wavelet, levels);
  for (std::size_t i = 0; i < x.size(); ++i) RC_ASSERT(std::abs(x[i] - shaped.samples[i]) < 2e-5f);
}

// The same bits as of the whole.
RC_GTEST_PROP(ShapeAdaptive, SomeFramesAreThoseOfTheWhole, ()) {
  const Extents e{*rc::gen::inRange(1, 17), *rc::gen::inRange(1, 17), *rc::gen::inRange(1, 17),
                  *rc::gen::inRange(1, 17)};
  const Wavelet wavelet = kWavelets[*rc::gen::inRange(0, 3)];
  const AxisLevels levels = blockLevels(e, *rc::gen::element(0, 1, 2, 4));
  const auto shaped = randomShape(sizeOf(e), *rc::gen::element(0.1, 0.5, 0.9, 1.0),
                                  *rc::gen::arbitrary<unsigned>());
  const int first = *rc::gen::inRange(0, e[0]);
  const int end = *rc::gen::inRange(first + 1, e[0] + 1);
  auto whole = shaped.samples;
  auto some = shaped.samples;
  shapeInverse(whole, shaped.support, e, wavelet, levels);
  shapeInverse(some, shaped.support, e, wavelet, levels, first, end);
  const std::size_t frame = whole.size() / static_cast<std::size_t>(e[0]);
  for (std::size_t i = first * frame; i < end * frame; ++i) RC_ASSERT(some[i] == whole[i]);
}

TEST(ShapeAdaptive, LineInverseRestores) {
  for (Wavelet wavelet : kWavelets) {
    for (unsigned seed = 0; seed < 200; ++seed) {
      const auto shaped = randomShape(1 + seed % 16, 0.6, seed);
      auto x = shaped.samples;
      shapeForwardLine(x, shaped.support, wavelet);
      shapeInverseLine(x, shaped.support, wavelet);
      for (std::size_t i = 0; i < x.size(); ++i) ASSERT_NEAR(x[i], shaped.samples[i], 1e-6);
    }
  }
}

TEST(ShapeAdaptive, NormsAreThoseOfTheBasisFunctions) {
  for (Wavelet wavelet : kWavelets) {
    for (int levels = 1; levels <= 4; ++levels) {
      for (bool high : {false, true}) {
        constexpr std::ptrdiff_t kCount = 1024;
        std::vector<double> x(kCount);
        x[kCount / 2 + (high ? 1 << (levels - 1) : 0)] = 1;
        for (int level = levels; level-- > 0;)
          liftInverse(x.data(), kCount >> level, std::ptrdiff_t{1} << level, wavelet);
        double sum = 0;
        for (double value : x) sum += value * value;
        EXPECT_NEAR(synthesisNorm(wavelet, levels, high), std::sqrt(sum), 1e-9);
      }
    }
  }
}

}  // namespace
}  // namespace volute
