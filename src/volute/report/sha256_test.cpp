// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/report/sha256.hpp"

#include <gtest/gtest.h>

#include <string>

namespace volute {
namespace {

std::string sum(const std::string& text, std::size_t part) {
  Sha256 sum;
  for (std::size_t at = 0; at < text.size(); at += part)
    sum.add(std::as_bytes(std::span(text).subspan(at, std::min(part, text.size() - at))));
  return sum.finish();
}

TEST(Sha256, OfTheStandardsExamplesInAnyParts) {
  const std::string two = "abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq";
  for (const std::size_t part : {1U, 7U, 64U, 1000000U}) {
    EXPECT_EQ(sum("", part), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
    EXPECT_EQ(sum("abc", part), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    EXPECT_EQ(sum(two, part), "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
    EXPECT_EQ(sum(std::string(1000000, 'a'), part),
              "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
  }
}

}  // namespace
}  // namespace volute
