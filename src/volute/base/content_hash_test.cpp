// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/content_hash.hpp"

#include <gtest/gtest.h>

#include <set>
#include <vector>

namespace volute {
namespace {

std::string hashOf(const std::vector<std::uint8_t>& bytes) {
  ContentHash hash;
  hash.add(std::span<const std::uint8_t>(bytes));
  return hash.digits();
}

TEST(ContentHash, TellsSmallChangesApart) {
  std::vector<std::uint8_t> bytes(37, 0);
  std::set<std::string> seen{hashOf(bytes)};
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    for (int bit = 0; bit < 8; ++bit) {
      bytes[i] ^= std::uint8_t(1 << bit);
      seen.insert(hashOf(bytes));
      bytes[i] ^= std::uint8_t(1 << bit);
    }
    seen.insert(hashOf(std::vector<std::uint8_t>(i, 0)));
  }
  EXPECT_EQ(seen.size(), 1 + 37 * 9);
  EXPECT_EQ(hashOf(bytes), hashOf(bytes));
  EXPECT_EQ(hashOf(bytes).size(), 32u);
}

TEST(ContentHash, KnowsWhereOnePartEnds) {
  const std::vector<std::uint8_t> bytes(16, 7);
  const std::span<const std::uint8_t> all(bytes);
  ContentHash whole, parts;
  whole.add(all);
  parts.add(all.first(8));
  parts.add(all.last(8));
  EXPECT_NE(whole.digits(), parts.digits());
}

}  // namespace
}  // namespace volute
