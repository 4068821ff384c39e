// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/byte_io.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>

#include "volute/codec/packing.hpp"
#include "volute/codec/step_search.hpp"

namespace volute {
namespace {

RC_GTEST_PROP(ByteIo, NumbersComeBack,
              (std::uint64_t a, std::int64_t b, double c, const std::string& text)) {
  ByteWriter out;
  out.varint(a);
  out.zigzag(b);
  out.f64(c);
  out.string(text);
  out.u16(513);
  ByteReader in(out.view());
  RC_ASSERT(in.varint() == a);
  RC_ASSERT(in.zigzag() == b);
  RC_ASSERT(in.f64() == c);
  RC_ASSERT(in.string() == text);
  RC_ASSERT(in.u8() == 1 && in.u8() == 2);
  RC_ASSERT(in.ok() && in.remaining() == 0);
  in.u8();
  RC_ASSERT(!in.ok());
}

TEST(ByteIo, OverlongVarintsAreFaults) {
  for (const std::size_t length : {9u, 10u, 11u}) {
    std::vector<std::byte> bytes(length, std::byte{0xFF});
    bytes.push_back(std::byte{1});
    ByteReader in(bytes);
    in.varint();
    EXPECT_EQ(in.ok(), length == 9) << length;
  }
}

RC_GTEST_PROP(Packing, ContentComesBack, ()) {
  const auto a = *rc::gen::container<std::vector<std::uint8_t>>(
      *rc::gen::inRange<std::size_t>(0, 4000),
      rc::gen::inRange<std::uint8_t>(0, *rc::gen::inRange(1, 255)));
  const auto b = *rc::gen::arbitrary<std::vector<std::uint8_t>>();
  const auto packed = pack({std::as_bytes(std::span(a)), std::as_bytes(std::span(b))});
  RC_ASSERT(packed.size() <= a.size() + b.size() + 1);
  RC_ASSERT(packed.empty() == (a.empty() && b.empty()));
  if (packed.empty()) {
    RC_ASSERT(unpack(packed, 100).error().code == ErrorCode::kInvalidData);
    return;
  }
  const auto content = unpack(packed, a.size() + b.size());
  RC_ASSERT(content.has_value());
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(content->data());
  RC_ASSERT(std::equal(a.begin(), a.end(), bytes) &&
            std::equal(b.begin(), b.end(), bytes + a.size()));
  RC_ASSERT(!unpack(packed, a.size() + b.size() - 1));
}

TEST(StepSearch, FindsTheTargetOfAPowerLaw) {
  for (const bool grows : {true, false}) {
    for (const double exponent : {0.5, 1.0, 3.0}) {
      StepSearch search({.target = 100,
                         .closeEnough = 95,
                         .grows = grows,
                         .finest = 1e-6,
                         .coarsest = 1e6,
                         .maxTries = 20},
                        1e-3);
      int tries = 0;
      double outcome = 0;
      for (; !search.found() && !search.failed(); ++tries) {
        outcome = 50 * std::pow(search.step(), grows ? exponent : -exponent);
        search.tell(outcome);
      }
      EXPECT_TRUE(search.found());
      EXPECT_LE(outcome, 100);
      EXPECT_GE(outcome, 95);
      EXPECT_LE(tries, 20);
    }
  }
}

TEST(StepSearch, ComesNearWhereSizesHardlyDependOnSteps) {
  // Nearly lossless: a bit for each halving of the step.
  const auto bytes = [](double step) { return 2.4e6 - 1e5 * std::log2(step / 1e-7); };
  StepSearch search(
      {.target = 1e6, .closeEnough = 0.99e6, .grows = false, .finest = 1e-7, .coarsest = 1}, 1e-7);
  int tries = 0;
  for (; !search.found() && !search.failed() && tries < 40; ++tries)
    search.tell(bytes(search.step()));
  EXPECT_TRUE(search.found());
  EXPECT_LE(bytes(search.step()), 1e6);
  EXPECT_GE(bytes(search.step()), 0.9e6) << tries;
}

TEST(StepSearch, ComesNearInFewTriesByWhatIsPredicted) {
  // From a byte for each of 1e8 values, over where most are coded by few bits, to nearly none.
  const auto bytes = [](double power, double scale, double step) {
    return 2000 + scale * 1e7 * std::log2(1 + std::pow(1e-3 / step, power));
  };
  for (const double target : {1e4, 1e5, 1e6, 1e7, 1e8, 1.5e8}) {
    for (const double first : {1e-9, 1e-6, 1e-3, 1.0}) {
      StepSearch search({.target = target,
                         .closeEnough = 0.99 * target,
                         .grows = false,
                         .finest = 1e-9,
                         .coarsest = 10,
                         .predict = [&](double step) { return bytes(1, 1, step); }},
                        first);
      int tries = 0;
      double outcome = 0;
      for (; !search.found() && !search.failed(); ++tries) {
        outcome = bytes(1.2, 0.7, search.step());
        search.tell(outcome);
      }
      EXPECT_TRUE(search.found());
      EXPECT_LE(outcome, target);
      EXPECT_GE(outcome, 0.8 * target) << target << " from " << first;
      EXPECT_LE(tries, 9) << target << " from " << first;
    }
  }
}

TEST(StepSearch, FailsOnlyAfterTheSafestStep) {
  StepSearch search({.target = 1, .closeEnough = 0.9, .grows = true, .finest = 0.25, .coarsest = 8},
                    4);
  double last = 0;
  while (!search.failed()) {
    ASSERT_FALSE(search.found());
    last = search.step();
    search.tell(2);
  }
  EXPECT_EQ(last, 0.25);
}

TEST(StepSearch, EndsOnAStepThatMeetsTheTargetWhateverTheOutcomesDo) {
  std::uint32_t seed = 7;
  for (int round = 0; round < 200; ++round) {
    StepSearch search({.target = 1,
                       .closeEnough = 0.99,
                       .grows = round % 2 == 0,
                       .finest = 1e-3,
                       .coarsest = 1e3},
                      1);
    const std::uint32_t salt = seed = seed * 1664525u + 1013904223u;
    int tries = 0;
    double outcome = 0;
    for (; !search.found() && !search.failed(); ++tries) {
      ASSERT_LT(tries, 20);
      outcome = static_cast<double>(
                    (static_cast<std::uint32_t>(search.step() * 1e6) ^ salt) * 2654435761u >> 16) /
                32768;
      search.tell(outcome);
    }
    EXPECT_TRUE(search.failed() || outcome <= 1);
  }
}

}  // namespace
}  // namespace volute
