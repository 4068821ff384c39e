// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/arithmetic_coder.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <random>

#include "volute/codec/contexts.hpp"
#include "volute/codec/symbol_coder.hpp"

namespace volute {
namespace {

// Bits of which `share` are 1; every third one is even.
std::vector<bool> someBits(std::size_t count, double share, unsigned seed) {
  std::mt19937 random(seed);
  std::bernoulli_distribution one(share), half(0.5);
  std::vector<bool> bits(count);
  for (std::size_t i = 0; i < count; ++i) bits[i] = i % 3 == 2 ? half(random) : one(random);
  return bits;
}

std::vector<std::byte> encoded(const std::vector<bool>& bits) {
  ArithmeticEncoder out;
  AdaptiveBit states[2];
  for (std::size_t i = 0; i < bits.size(); ++i) {
    if (i % 3 == 2)
      out.even(bits[i]);
    else
      out.bit(states[i % 3], bits[i]);
  }
  return out.finish();
}

std::vector<bool> decoded(std::span<const std::byte> bytes, std::size_t count, bool& usedAll) {
  ArithmeticDecoder in(bytes);
  AdaptiveBit states[2];
  std::vector<bool> bits(count);
  for (std::size_t i = 0; i < count; ++i) bits[i] = i % 3 == 2 ? in.even() : in.bit(states[i % 3]);
  usedAll = in.usedAll();
  return bits;
}

RC_GTEST_PROP(ArithmeticCoder, BitsComeBack, ()) {
  const auto bits =
      someBits(*rc::gen::inRange<std::size_t>(0, 3000),
               *rc::gen::element(0.0, 1e-4, 0.02, 0.5, 0.97, 1.0), *rc::gen::arbitrary<unsigned>());
  const auto bytes = encoded(bits);
  bool usedAll = false;
  RC_ASSERT(decoded(bytes, bits.size(), usedAll) == bits);
  RC_ASSERT(usedAll);
}

TEST(ArithmeticCoder, MoreBytesThanBitsAreNoticed) {
  const auto bits = someBits(900, 0.1, 5);
  auto bytes = encoded(bits);
  bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(bytes.size() / 2), 40, std::byte{77});
  bool usedAll = true;
  (void)decoded(bytes, bits.size(), usedAll);
  EXPECT_FALSE(usedAll);
}

TEST(ArithmeticCoder, AnyBytesGiveBits) {
  std::mt19937 random(1);
  for (std::size_t size = 0; size < 40; ++size) {
    std::vector<std::byte> bytes(size);
    for (std::byte& byte : bytes) byte = static_cast<std::byte>(random());
    bool usedAll = false;
    EXPECT_EQ(decoded(bytes, 2000, usedAll).size(), 2000u);
  }
}

// Within some percent of the entropy, for bits of any skew: what the estimates and the 64-bit
// interval are worth.
TEST(ArithmeticCoder, CostsTheEntropy) {
  for (double share : {0.003, 0.03, 0.2, 0.5}) {
    std::mt19937 random(3);
    std::bernoulli_distribution one(share);
    constexpr std::size_t kCount = 200000;
    ArithmeticEncoder out;
    AdaptiveBit state;
    for (std::size_t i = 0; i < kCount; ++i) out.bit(state, one(random));
    const double entropy = -share * std::log2(share) - (1 - share) * std::log2(1 - share);
    EXPECT_LT(static_cast<double>(out.finish().size()) * 8, 1.04 * entropy * kCount + 64) << share;
  }
}

TEST(AdaptiveBit, StaysInRange) {
  for (bool bit : {false, true}) {
    AdaptiveBit state;
    for (int i = 0; i < 10000; ++i) state.learn(bit);
    EXPECT_GE(state.one, AdaptiveBit::kMin);
    EXPECT_LE(state.one, 65536 - AdaptiveBit::kMin);
    EXPECT_EQ(state.seen, AdaptiveBit::kMax);
  }
}

TEST(Contexts, TableSaysWhatCountsSuggest) {
  ContextCounts counts;
  std::mt19937 random(7);
  for (auto& seen : counts.seen) {
    if (random() % 3 != 0)
      continue;
    const double share = std::pow(static_cast<double>(random() % 1000) / 1000, 3);
    const std::uint32_t total = random() % 5000;
    seen = {static_cast<std::uint32_t>((1 - share) * total),
            static_cast<std::uint32_t>(share * total)};
  }
  const auto table = contextTable(counts);
  const Contexts contexts = contextsOf(table);
  ASSERT_EQ(contexts.size(), std::size_t{context::kCount});
  for (std::size_t i = 0; i < contexts.size(); ++i) {
    const double total = static_cast<double>(counts.seen[i][0]) + counts.seen[i][1];
    if (total < 100)
      continue;
    // In units in which a probability is equally precise everywhere.
    const double wanted = std::asin(std::sqrt((counts.seen[i][1] + 0.4) / (total + 0.8)));
    const double got = std::asin(std::sqrt(contexts[i].one / 65536.0));
    EXPECT_NEAR(got, wanted, 0.025);
  }
  EXPECT_LT(table.size(), contexts.size());
}

TEST(Contexts, AnyTableIsOne) {
  std::mt19937 random(2);
  for (std::size_t size = 0; size < 300; size += 7) {
    std::vector<std::byte> bytes(size);
    for (std::byte& byte : bytes) byte = static_cast<std::byte>(random());
    for (const AdaptiveBit& state : contextsOf(bytes)) {
      ASSERT_GE(state.one, AdaptiveBit::kMin);
      ASSERT_LE(state.one, 65536 - AdaptiveBit::kMin);
    }
  }
}

TEST(SymbolCoder, WhatWasWrittenComesBack) {
  std::mt19937 random(5);
  const auto tables = symbolsOfTable({});
  for (const std::size_t count : {0, 1, 5, 60, 3000}) {
    struct Item {
      unsigned context, symbol;  // or plain bits
      int bits;
    };

    std::vector<Item> items;
    std::vector<bool> signs;
    SymbolWriter out;
    for (std::size_t i = 0; i < count; ++i) {
      const auto lane = static_cast<unsigned>(i % kLanes);
      if (random() % 8 == 0) {
        const int bits = static_cast<int>(random() % 16);
        items.push_back({0, static_cast<unsigned>(random() & ((1u << bits) - 1)), bits});
        out.bits(items.back().symbol, bits, lane);
        continue;
      }
      const auto context = static_cast<unsigned>(random() % symbol::kCount);
      const auto all = static_cast<unsigned>(symbol::symbolsOf(context));
      items.push_back({context, static_cast<unsigned>(random() % all), -1});
      out.symbol(context, items.back().symbol, lane);
      signs.push_back(random() % 2 == 0);
      out.sign(signs.back());
    }
    auto bytes = out.finish(tables);
    bytes.insert(bytes.begin(), std::byte{0xA5});  // what stands before it is not read
    SymbolReader in(bytes);
    for (std::size_t i = 0; i < count; ++i) {
      const unsigned lane = static_cast<unsigned>(i % kLanes) & (in.lanes() - 1);
      const Item& item = items[i];
      ASSERT_EQ(item.bits < 0 ? in.symbol(tables[item.context], lane) : in.bits(item.bits, lane),
                item.symbol);
    }
    std::size_t at = 0;
    in.signs(signs.size(), [&](std::uint32_t sign) { EXPECT_EQ(sign != 0, signs[at++]); });
    EXPECT_TRUE(in.good());
    EXPECT_EQ(in.left(), 1u);
  }
}

TEST(SymbolTables, AnyBytesGiveSymbolsThatAddUp) {
  std::mt19937 random(6);
  for (int round = 0; round < 30; ++round) {
    std::vector<std::byte> table(static_cast<std::size_t>(round) * 50);
    for (std::byte& byte : table) byte = static_cast<std::byte>(random());
    for (const SymbolEnds& one : symbolsOfTable(table)) {
      for (std::size_t s = 0; s + 1 < one.ends.size(); ++s) ASSERT_GE(one.ends[s + 1], one.ends[s]);
      ASSERT_EQ(one.ends.back(), (1 << symbol::kProbabilityBits) - 1);
    }
  }
}

}  // namespace
}  // namespace volute
