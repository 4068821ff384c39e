// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/content_hash.hpp"

#include <fmt/format.h>

#include <bit>
#include <cstring>

namespace volute {
namespace {

/// A bijection of 64 bits in which each bit moves half of the others (Appleby's MurmurHash3).
std::uint64_t stirred(std::uint64_t word) {
  word = (word ^ (word >> 33)) * 0xff51afd7ed558ccd;
  word = (word ^ (word >> 33)) * 0xc4ceb9fe1a85ec53;
  return word ^ (word >> 33);
}

}  // namespace

void ContentHash::mix(std::uint64_t word) {
  a_ = std::rotl(a_ ^ (word * 0x87c37b91114253d5), 31) * 5 + 0x52dce729;
  b_ = std::rotl(b_ + stirred(word), 29) * 0x9fb21c651e98df25 + a_;
}

void ContentHash::add(std::span<const std::byte> bytes) {
  mix(bytes.size());
  std::size_t at = 0;
  for (; at + 8 <= bytes.size(); at += 8) {
    std::uint64_t word;
    std::memcpy(&word, &bytes[at], 8);
    mix(word);
  }
  std::uint64_t rest = 0;
  if (at < bytes.size())
    std::memcpy(&rest, &bytes[at], bytes.size() - at);
  mix(rest);
}

std::string ContentHash::digits() const {
  return fmt::format("{:016x}{:016x}", stirred(a_ + b_), stirred(b_ ^ stirred(a_)));
}

}  // namespace volute
