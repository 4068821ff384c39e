// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

// Binary arithmetic coding with adaptive probabilities (docs/format.md, section 8). Integers only:
// the same bytes everywhere.

namespace volute {

/// An estimate of how likely a bit is 1, which learns from the bits seen.
struct AdaptiveBit {
  std::uint16_t one = 32768;  ///< probability of 1, in 1/65536; kMin to 65536 - kMin
  std::uint8_t seen = 0;      ///< how sure it is: bits seen, at most kMax

  static constexpr int kMin = 64;
  static constexpr int kMax = 250;

  void learn(bool bit) {
    const int change = (bit ? 65535 : 0) - one;
    const int next = one + (change * kRate[seen] >> 15);
    one = static_cast<std::uint16_t>(std::clamp(next, kMin, 65536 - kMin));
    seen = static_cast<std::uint8_t>(seen + (seen < kMax ? 1 : 0));
  }

 private:
  /// 1 / (seen + 1.6) in 1/32768.
  static constexpr std::array<int, kMax + 1> kRate = [] {
    std::array<int, kMax + 1> rate{};
    for (int n = 0; n <= kMax; ++n) rate[n] = 327680 / (10 * n + 16);
    return rate;
  }();
};

/// Writes bits into a byte string: those with estimates from its front, even ones, which need no
/// arithmetic, from its end backwards. The interval [low, low + range) shrinks to the part of each
/// bit; a carry out of `low` runs back into the bytes that are written.
class ArithmeticEncoder {
 public:
  void bit(AdaptiveBit& state, bool value) {
    const std::uint64_t bound = (range_ >> 16) * state.one;
    state.learn(value);
    if (value) {
      range_ = bound;
    } else {
      low_ += bound;
      if (low_ < bound)
        carry();
      range_ -= bound;
    }
    if (range_ < std::uint64_t{1} << 32) {
      for (int shift = 56; shift >= 32; shift -= 8) push(low_ >> shift);
      low_ <<= 32;
      range_ <<= 32;
    }
  }

  /// A bit that is as often 0 as 1.
  void even(bool value) {
    if (evenCount_ % 8 == 0)
      even_.push_back(std::byte{0});
    if (value)
      even_.back() |= std::byte{1} << evenCount_ % 8;
    ++evenCount_;
  }

  /// Bytes so far.
  std::size_t size() const { return bytes_.size() + even_.size(); }

  /// Ends the string.
  std::vector<std::byte> finish() {
    // The fewest bytes that say where in the interval, whatever follows them.
    for (int bytes = 0; bytes <= 8; ++bytes) {
      const std::uint64_t rest = bytes == 8 ? 0 : ~std::uint64_t{0} >> 8 * bytes;
      const std::uint64_t value = (low_ + rest) & ~rest;
      if (value - low_ >= range_ || range_ - (value - low_) <= rest)
        continue;
      if (low_ + rest < low_)
        carry();
      for (int i = 0; i < bytes; ++i) push(value >> (56 - 8 * i));
      break;
    }
    bytes_.insert(bytes_.end(), even_.rbegin(), even_.rend());
    return std::move(bytes_);
  }

 private:
  void push(std::uint64_t byte) { bytes_.push_back(static_cast<std::byte>(byte & 0xFF)); }

  void carry() {
    for (std::size_t i = bytes_.size(); i-- > 0;) {
      bytes_[i] = static_cast<std::byte>(static_cast<unsigned>(bytes_[i]) + 1);
      if (bytes_[i] != std::byte{0})
        return;
    }
  }

  std::vector<std::byte> bytes_, even_;
  std::size_t evenCount_ = 0;
  std::uint64_t low_ = 0;
  std::uint64_t range_ = ~std::uint64_t{0};
};

/// Reads what ArithmeticEncoder wrote. Any bytes give some bits; reads nothing beyond their ends.
class ArithmeticDecoder {
 public:
  explicit ArithmeticDecoder(std::span<const std::byte> bytes)
      : bytes_(bytes), evenBegin_(bytes.size()) {
    fill();
    fill();
  }

  bool bit(AdaptiveBit& state) {
    // Branches, not selections: a guess of the bit lets work on the next one begin.
    const std::uint64_t bound = (range_ >> 16) * state.one;
    if (code_ < bound) {
      range_ = bound;
      state.learn(true);
      refill();
      return true;
    }
    code_ -= bound;
    range_ -= bound;
    state.learn(false);
    refill();
    return false;
  }

  bool even() {
    if (evenLeft_ == 0) {
      for (; evenLeft_ < 64 && evenBegin_ > 0; evenLeft_ += 8)
        even_ |= static_cast<std::uint64_t>(bytes_[--evenBegin_]) << evenLeft_;
      if (evenLeft_ == 0)
        return false;
    }
    const bool value = (even_ & 1) != 0;
    even_ >>= 1;
    --evenLeft_;
    return value;
  }

  /// How many bytes bits have depended on, at most.
  std::size_t reached() const { return next_; }

  /// False when bytes are left that no bit depended on.
  bool usedAll() const { return next_ >= evenBegin_ + static_cast<std::size_t>(evenLeft_ / 8); }

 private:
  void refill() {
    if (range_ < std::uint64_t{1} << 32) [[unlikely]] {
      fill();
      range_ <<= 32;
    }
  }

  void fill() {
    std::uint64_t word = 0;
    for (int i = 0; i < 4; ++i, ++next_) {
      word = word << 8 | (next_ < bytes_.size() ? static_cast<std::uint64_t>(bytes_[next_]) : 0);
    }
    code_ = code_ << 32 | word;
  }

  std::span<const std::byte> bytes_;
  std::size_t next_ = 0, evenBegin_;
  std::uint64_t code_ = 0;
  std::uint64_t range_ = ~std::uint64_t{0};
  std::uint64_t even_ = 0;
  int evenLeft_ = 0;
};

}  // namespace volute
