// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <numeric>
#include <random>
#include <vector>

#include "volute/wavelet/quantiser.hpp"
#include "volute/wavelet/transform4d.hpp"

namespace volute {
namespace {

constexpr Wavelet kAllWavelets[] = {Wavelet::kHaar, Wavelet::kCdf53, Wavelet::kCdf97};

std::vector<double> noiseLine(std::size_t n, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<double> values(n);
  for (double& v : values) v = static_cast<double>(random()) / 4294967296.0 - 0.5;
  return values;
}

RC_GTEST_PROP(Lifting, InverseUndoesForwardOnAnyLength, ()) {
  const int n = *rc::gen::inRange(1, 40);
  const int stride = *rc::gen::inRange(1, 4);
  const Wavelet wavelet =
      *rc::gen::elementOf(std::vector<Wavelet>(std::begin(kAllWavelets), std::end(kAllWavelets)));
  const auto original = noiseLine(static_cast<std::size_t>(n) * stride, n * 7 + stride);
  auto x = original;
  liftForward(x.data(), n, stride, wavelet);
  liftInverse(x.data(), n, stride, wavelet);
  for (std::size_t i = 0; i < x.size(); ++i) RC_ASSERT(std::abs(x[i] - original[i]) < 1e-14);
}

TEST(Lifting, ConstantsHaveNoHighAndLinesNoneInside) {
  for (Wavelet wavelet : kAllWavelets) {
    for (int n : {2, 3, 8, 17}) {
      std::vector<double> x(n, 3.0);
      liftForward(x.data(), n, 1, wavelet);
      for (int i = 0; i < n; ++i)
        EXPECT_NEAR(x[i], i % 2 == 0 ? 3 * std::sqrt(2.0) : 0, 1e-9) << waveletName(wavelet) << n;
    }
  }
  for (Wavelet wavelet : {Wavelet::kCdf53, Wavelet::kCdf97}) {
    std::vector<double> x(32);
    std::iota(x.begin(), x.end(), 0.0);
    liftForward(x.data(), 32, 1, wavelet);
    for (int i = 5; i < 27; i += 2) EXPECT_NEAR(x[i], 0, 1e-9);
  }
}

TEST(Lifting, HaarIsOrthonormal) {
  auto x = noiseLine(64, 1);
  const double before = std::inner_product(x.begin(), x.end(), x.begin(), 0.0);
  liftForward(x.data(), 64, 1, Wavelet::kHaar);
  EXPECT_NEAR(std::inner_product(x.begin(), x.end(), x.begin(), 0.0), before, 1e-12);
}

TEST(Lifting, NamesGoBothWays) {
  for (Wavelet wavelet : kAllWavelets) EXPECT_EQ(waveletByName(waveletName(wavelet)), wavelet);
  EXPECT_FALSE(waveletByName("db4"));
}

RC_GTEST_PROP(Transform4d, InverseUndoesForwardOnAnySize, ()) {
  std::array<std::ptrdiff_t, 4> extents{};
  std::size_t count = 1;
  for (auto& e : extents) {
    e = *rc::gen::inRange(1, 10);
    count *= static_cast<std::size_t>(e);
  }
  const Wavelet wavelet =
      *rc::gen::elementOf(std::vector<Wavelet>(std::begin(kAllWavelets), std::end(kAllWavelets)));
  const int full = static_cast<int>(
      std::bit_width(static_cast<std::size_t>(*std::ranges::max_element(extents) - 1)));
  std::array<int, 4> levels{};
  for (int& l : levels) l = *rc::gen::inRange(0, full + 1);
  const auto original = noiseLine(count, static_cast<unsigned>(count));
  auto x = original;
  const View<double, 4> view(std::span<double>(x), extents);
  transformForward(view, wavelet, levels);
  transformInverse(view, wavelet, levels);
  for (std::size_t i = 0; i < count; ++i) RC_ASSERT(std::abs(x[i] - original[i]) < 1e-12);
}

TEST(Transform4d, HaarScalingCoefficientIsTheScaledMean) {
  auto x = noiseLine(16 * 16 * 16 * 16, 2);
  const double mean = std::accumulate(x.begin(), x.end(), 0.0) / static_cast<double>(x.size());
  transformForward(View<double, 4>(std::span<double>(x), {16, 16, 16, 16}), Wavelet::kHaar,
                   {4, 4, 4, 4});
  EXPECT_NEAR(x[0], mean * 256, 1e-10);  // 4^levels
}

TEST(Transform4d, FloatStaysCloseToDouble) {
  const auto original = noiseLine(5 * 9 * 6 * 12, 3);
  for (Wavelet wavelet : kAllWavelets) {
    auto exact = original;
    std::vector<float> fast(original.begin(), original.end());
    transformForward(View<double, 4>(std::span<double>(exact), {5, 9, 6, 12}), wavelet,
                     {2, 3, 3, 3});
    transformForward(View<float, 4>(std::span<float>(fast), {5, 9, 6, 12}), wavelet, {2, 3, 3, 3});
    for (std::size_t i = 0; i < exact.size(); ++i) EXPECT_NEAR(fast[i], exact[i], 2e-5);
  }
}

TEST(QuantisationModel, PredictsTheErrorOfLaplaceNoise) {
  std::mt19937 random(4);
  std::exponential_distribution<float> laplace(1.0f);
  QuantisationModel model;
  std::vector<float> coefficients(200000);
  for (float& c : coefficients) model.add(c = laplace(random) * (random() % 2 ? 1.0f : -1.0f));
  for (float step : {0.01f, 0.3f, 1.0f, 3.0f}) {
    double measured = 0;
    for (float c : coefficients) {
      const double e = c - static_cast<double>(quantise(c, 1 / step)) * step;
      measured += e * e;
    }
    EXPECT_NEAR(model.squaredError(step) / measured, 1, 0.02) << step;
    EXPECT_NEAR(model.stepFor(measured) / step, 1, 0.02) << step;
  }
}

TEST(QuantisationModel, PredictsTheBitsOfLaplaceNoise) {
  std::mt19937 random(5);
  std::exponential_distribution<float> laplace(1.0f);
  QuantisationModel model;
  std::vector<float> coefficients(200000);
  for (float& c : coefficients) model.add(c = laplace(random) * (random() % 2 ? 1.0f : -1.0f));
  double before = model.bits(100);
  for (const float step : {5.0f, 2.0f, 0.5f, 0.1f, 0.01f, 0.0001f}) {
    std::map<std::int32_t, double> counts;
    for (const float c : coefficients) ++counts[quantise(c, 1 / step)];
    double entropy = 0;
    for (const auto& [symbol, count] : counts) entropy += count * std::log2(200000 / count);
    // Counted symbols have less entropy than there is once most of them are there but once.
    if (step > 0.001f) {
      EXPECT_NEAR(model.bits(step) / entropy, 1, 0.25) << step;
    }
    EXPECT_GT(model.bits(step), before);
    before = model.bits(step);
  }
}

TEST(QuantisationModel, WithoutCoefficientsThereIsNoStep) {
  QuantisationModel model;
  model.add(0);
  EXPECT_EQ(model.stepFor(1), 0);
}

}  // namespace
}  // namespace volute
