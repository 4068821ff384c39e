// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/wavelet_codec.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <random>

#include "volute/codec/block_encoder.hpp"
#include "volute/codec/codec_testing.hpp"

namespace volute {
namespace {

using Kind = ErrorTarget::Kind;
using namespace testing;

struct Block {
  BlockShape shape;
  std::vector<float> values;
};

// A moving ball with soft grain in empty space.
Block ball(const BlockGrid::Index4& extents, int channels, unsigned seed) {
  Block block{{extents, channels}, {}};
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> grain(0, 0.1f);
  for (int t = 0; t < extents[0]; ++t)
    for (int z = 0; z < extents[1]; ++z)
      for (int y = 0; y < extents[2]; ++y)
        for (int x = 0; x < extents[3]; ++x) {
          const float dx = static_cast<float>(x) - 6 - 0.3f * static_cast<float>(t);
          const float dy = static_cast<float>(y) - 7;
          const float dz = static_cast<float>(z) - 5;
          const float body = 1 - (dx * dx + dy * dy + dz * dz) / 40;
          for (int c = 0; c < channels; ++c)
            block.values.push_back(body > 0 ? body * static_cast<float>(c + 1) / 3 + grain(random)
                                            : 0);
        }
  return block;
}

StreamInfo infoOf(const Block& block) {
  const auto [least, most] = std::ranges::minmax(block.values);
  return {block.shape.channels, least, most};
}

struct RoundTrip {
  std::vector<std::vector<std::byte>> tiers;
  std::vector<float> decoded;
  std::string mode;
};

RoundTrip roundTrip(const Block& block, const WaveletParameters& parameters,
                    const std::optional<BlockMode>& mode) {
  RoundTrip result;
  Training training;
  const StreamInfo stream = infoOf(block);
  const BlockEncoder encoder(parameters, stream);
  result.tiers = encoder.encode(encoder.contentOf(block.values, block.shape, {}), mode, training);
  const auto decoder =
      openWaveletDecoder(parameters.extended ? kSparseCodec : kWaveletCodec,
                         writeParameters(parameters, block.shape.channels), stream);
  EXPECT_TRUE(decoder);
  result.decoded.resize(block.values.size());
  const auto status =
      (*decoder)->decode(result.tiers, block.shape.levels(), block.shape, result.decoded);
  EXPECT_TRUE(status) << status.error().message;
  result.mode = (*decoder)->describe(result.tiers, block.shape).value();
  return result;
}

// Of codec 3, with cells by symbols.
WaveletParameters bySymbols(double step) {
  WaveletParameters parameters;
  parameters.step = step;
  parameters.extended = parameters.bySymbols = true;
  parameters.symbols = symbolsOfTable({});
  parameters.symbolPrices = pricesOf(parameters.symbols);
  return parameters;
}

double rmsBetween(std::span<const float> a, std::span<const float> b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    sum += (static_cast<double>(a[i]) - b[i]) * (static_cast<double>(a[i]) - b[i]);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

TEST(WaveletCodec, EveryModeComesBackWithinItsStep) {
  for (int channels : {1, 3}) {
    const Block block = ball({16, 16, 16, 16}, channels, 1);
    WaveletParameters parameters;
    parameters.step = 0.02;
    for (const BlockMode& mode : allBlockModes()) {
      const auto result = roundTrip(block, parameters, mode);
      EXPECT_EQ(result.mode, describe(mode));
      EXPECT_LT(rmsBetween(block.values, result.decoded), 0.012) << describe(mode);
      EXPECT_EQ(blockModeByName(shortName(mode)), mode);
    }
  }
}

TEST(WaveletCodec, EveryModeComesBackBySymbols) {
  for (int channels : {1, 3}) {
    const Block block = ball({16, 16, 16, 16}, channels, 1);
    for (const BlockMode& mode : allBlockModes()) {
      const auto result = roundTrip(block, bySymbols(0.02), mode);
      EXPECT_EQ(result.mode, describe(mode));
      EXPECT_LT(rmsBetween(block.values, result.decoded), 0.012) << describe(mode);
    }
  }
}

TEST(WaveletCodec, TablesOfSymbolsMakeBlocksSmaller) {
  const Block block = ball({16, 16, 16, 16}, 1, 1);
  WaveletParameters parameters = bySymbols(0.02);
  Training training;
  const BlockEncoder encoder(parameters, infoOf(block));
  const auto bytes = [&] {
    std::size_t sum = 0;
    for (const auto& tier :
         encoder.encode(encoder.contentOf(block.values, block.shape, {}), BlockMode{}, training))
      sum += tier.size();
    return static_cast<double>(sum);
  };
  const double guessed = bytes();
  training.apply(parameters);
  EXPECT_LT(bytes(), 0.97 * guessed);
  const auto again = readParameters(kSparseCodec, writeParameters(parameters, 1), 1).value();
  EXPECT_EQ(again.symbolTable, parameters.symbolTable);
  for (unsigned i = 0; i < symbol::kCount; ++i)
    ASSERT_EQ(again.symbols[i].ends, parameters.symbols[i].ends) << i;
}

TEST(WaveletCodec, ASupportIsExact) {
  const Block block = ball({16, 16, 16, 16}, 3, 2);
  WaveletParameters parameters;
  parameters.step = 0.1;
  for (const BlockMode& mode : allBlockModes()) {
    if (!mode.shaped)
      continue;
    const auto result = roundTrip(block, parameters, mode);
    for (std::size_t i = 0; i < block.values.size(); ++i)
      ASSERT_TRUE(block.values[i] != 0 || result.decoded[i] == 0) << describe(mode);
  }
}

RC_GTEST_PROP(WaveletCodec, AnyBlockInAnyModeComesBack, ()) {
  const auto side = [] { return *rc::gen::inRange(1, 17); };
  const Block block = ball({side(), side(), side(), side()}, *rc::gen::element(1, 3),
                           *rc::gen::arbitrary<unsigned>());
  const BlockMode mode = allBlockModes()[*rc::gen::inRange<std::size_t>(0, 24)];
  WaveletParameters parameters = *rc::gen::arbitrary<bool>() ? bySymbols(1) : WaveletParameters();
  parameters.exponent = *rc::gen::inRange(-3, 4);
  parameters.step = 0.01 / parameters.unit();
  const auto result = roundTrip(block, parameters, mode);
  for (std::size_t i = 0; i < block.values.size(); ++i)
    RC_ASSERT(std::abs(block.values[i] - result.decoded[i]) < 0.12f);
}

TEST(WaveletCodec, CorrectionsKeepTheMaximumError) {
  const Block block = ball({7, 16, 11, 16}, 3, 3);
  for (double bound : {0.1, 0.01, 1e-4}) {
    for (double factor : {0.5, 2.0, 20.0}) {
      for (WaveletParameters parameters : {WaveletParameters(), bySymbols(1)}) {
        parameters.step = factor * bound;
        parameters.maxError = bound;
        for (const BlockMode& mode : {BlockMode{}, BlockMode{true, Wavelet::kCdf53, 0}}) {
          const auto result = roundTrip(block, parameters, mode);
          for (std::size_t i = 0; i < block.values.size(); ++i)
            ASSERT_LE(std::abs(static_cast<double>(block.values[i]) - result.decoded[i]), bound);
        }
      }
    }
  }
}

TEST(WaveletCodec, TheChosenModeIsNotWorseThanAny) {
  const Block block = ball({16, 16, 16, 16}, 1, 4);
  WaveletParameters parameters;
  parameters.step = 0.05;
  const BlockEncoder encoder(parameters, infoOf(block));
  const auto chosen =
      encoder.choose(encoder.contentOf(block.values, block.shape, {}), {allBlockModes()});
  ASSERT_TRUE(chosen);
  const auto costOf = [&](const BlockMode& mode) {
    const auto result = roundTrip(block, parameters, mode);
    double bits = 0;
    for (const auto& tier : result.tiers) bits += 8 * static_cast<double>(tier.size());
    const double error = rmsBetween(block.values, result.decoded) / parameters.step;
    return error * error * static_cast<double>(block.values.size()) + 0.16 * bits;
  };
  const double least = costOf(*chosen);
  for (const BlockMode& mode : allBlockModes()) EXPECT_LT(least, 1.03 * costOf(mode));
  // Nor is one that was found from another, or from an estimate.
  for (const BlockMode& start : allBlockModes()) {
    const auto found = encoder.choose(encoder.contentOf(block.values, block.shape, {}),
                                      {allBlockModes(), std::span(&start, 1)});
    ASSERT_TRUE(found) << describe(start);
    EXPECT_LT(costOf(*found), 1.03 * least) << describe(start);
  }
  for (const int coded : {0, 1, 2, 3}) {
    const auto found = encoder.choose(encoder.contentOf(block.values, block.shape, {}),
                                      {allBlockModes(), {}, coded});
    ASSERT_TRUE(found);
    EXPECT_LT(costOf(*found), (coded < 2 ? 1.06 : 1.03) * least) << coded;
  }
}

TEST(WaveletCodec, WhatIsNotWorthABitIsLeftOut) {
  Block block = ball({4, 16, 16, 16}, 1, 5);
  for (float& value : block.values) value *= 1e-3f;
  WaveletParameters parameters;
  parameters.step = 1;
  const BlockEncoder encoder(parameters, infoOf(block));
  EXPECT_FALSE(encoder.choose(encoder.contentOf(block.values, block.shape, {}), {allBlockModes()}));
  // But not where a bound on the error forbids it.
  parameters.maxError = 1e-5;
  EXPECT_TRUE(encoder.choose(encoder.contentOf(block.values, block.shape, {}), {allBlockModes()}));
}

TEST(WaveletCodec, HostileBytesGiveErrorsOrFiniteValues) {
  std::mt19937 random(11);
  for (int channels : {1, 3}) {
    const BlockShape shape{{16, 7, 16, 9}, channels};
    std::vector<float> values(shape.values());
    for (int round = 0; round < 200; ++round) {
      WaveletParameters parameters = round % 2 == 0 ? WaveletParameters() : bySymbols(1);
      parameters.step = 1e300;
      parameters.maxError = 1e30;
      const auto decoder =
          openWaveletDecoder(round % 2 == 0 ? kWaveletCodec : kSparseCodec,
                             writeParameters(parameters, channels), {channels, -1, 1});
      ASSERT_TRUE(decoder);
      std::vector<std::vector<std::byte>> tiers(1 + random() % 3);
      for (auto& tier : tiers) {
        tier.resize(random() % 4 == 0 ? 0 : random() % 4000);
        for (auto& byte : tier) byte = static_cast<std::byte>(random());
      }
      if ((*decoder)->decode(tiers, 1 + static_cast<int>(random() % 5), shape, values)) {
        for (const float value : values) ASSERT_TRUE(std::isfinite(value));
      }
      (void)(*decoder)->describe(tiers, shape);
    }
  }
}

TEST(WaveletCodec, ImpossibleParametersAreRefused) {
  std::vector<WaveletParameters> bad(5);
  bad[0].step = 0;
  bad[1].step = NAN;
  bad[2].exponent = 200;
  bad[3].one = 0;
  bad[4].maxError = -1;
  for (const WaveletParameters& parameters : bad)
    EXPECT_FALSE(readParameters(kWaveletCodec, writeParameters(parameters, 1), 1));
  EXPECT_FALSE(readParameters(kWaveletCodec, {}, 1));
}

TEST(ColorTransform, IsOrthonormalAndComesBack) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> value(0, 1);
  std::vector<float> values;
  for (int i = 0; i < 3000; ++i) {
    const float light = value(random);
    for (float share : {0.9f, 0.5f, 0.1f}) values.push_back(light * share + 0.01f * value(random));
  }
  ColorMoments moments;
  moments.add(values, 3);
  const ColorTransform transform = ColorTransform::of(moments);
  const auto planes = transform.split(values, 3, 4);
  std::vector<float> back(values.size());
  transform.merge(planes, 3, 4, back);
  for (std::size_t i = 0; i < values.size(); ++i) ASSERT_NEAR(back[i], values[i], 1e-6);
  double first = 0, rest = 0;
  for (std::size_t i = 0; i < planes.size(); ++i)
    (i < 3000 ? first : rest) += static_cast<double>(planes[i]) * planes[i];
  EXPECT_LT(rest, 1e-3 * first);
}

TEST(ForcedModes, AreUsedForAllBlocksAndNotMuchSmallerThanTheChoice) {
  const Sequence sequence = plumes(20, 20, 33, 20);
  const auto bytesOf = [&](const std::optional<BlockMode>& mode, std::string* first) {
    SequenceSource source(sequence);
    CompressOptions options;
    options.target = {Kind::kRms, 3e-3};
    options.mode = mode;
    Progress progress;
    const ScratchFile file;
    const auto report = compress(source, file.path(), options, progress);
    EXPECT_TRUE(report) << report.error().message;
    if (first != nullptr)
      *first = VoluteReader::open(file.path())->describeBlock(0).value();
    return static_cast<double>(report->fileBytes);
  };
  const double chosen = bytesOf(std::nullopt, nullptr);
  for (const BlockMode& mode :
       {BlockMode{}, BlockMode{true, Wavelet::kCdf97, 4}, BlockMode{true, Wavelet::kHaar, 0},
        BlockMode{false, Wavelet::kCdf53, 1}}) {
    std::string used;
    EXPECT_LT(chosen, 1.01 * bytesOf(mode, &used)) << describe(mode);
    EXPECT_EQ(used, describe(mode));
  }
}

}  // namespace
}  // namespace volute
