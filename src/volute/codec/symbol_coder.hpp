// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "volute/codec/symbol_tables.hpp"

// Asymmetric numeral systems (Duda 2013) over tables of symbols, in four lanes that take turns, so
// that a CPU works on several at once (docs/format.md, 10.4). A string is read from its end
// backwards. Integers only.

namespace volute {

inline constexpr unsigned kLanes = 4;

/// Collects symbols, plain bits and signs; the string is made of them from the last one to the
/// first.
class SymbolWriter {
 public:
  void symbol(unsigned context, unsigned symbol, unsigned lane) {
    steps_.push_back({static_cast<std::uint16_t>(context), static_cast<std::uint8_t>(symbol),
                      static_cast<std::uint8_t>(lane)});
  }

  /// At most 15 bits.
  void bits(std::uint32_t value, int count, unsigned lane) {
    steps_.push_back({static_cast<std::uint16_t>(value),
                      static_cast<std::uint8_t>(kPlain + static_cast<unsigned>(count)),
                      static_cast<std::uint8_t>(lane)});
  }

  void sign(bool negative) { signs_.push_back(negative); }

  std::vector<std::byte> finish(std::span<const SymbolEnds> symbols) const {
    // The states that a reader ends with hold signs.
    const unsigned lanes = signs_.size() >= 16 * kLanes ? kLanes : 1;
    const auto sign = [&](std::size_t i) { return i < signs_.size() && signs_[i] ? 1u : 0u; };
    std::array<std::uint32_t, kLanes> x{};
    for (unsigned i = 0; i < 16 * lanes; ++i) x[i / 16] |= sign(i) << i % 16;
    std::vector<std::byte> out;
    const std::size_t inLanes = 16 * lanes;
    const std::size_t rest = signs_.size() > inLanes ? (signs_.size() - inLanes + 7) / 8 : 0;
    for (std::size_t byte = rest; byte-- > 0;) {
      unsigned value = 0;
      for (unsigned bit = 0; bit < 8; ++bit) value |= sign(inLanes + 8 * byte + bit) << bit;
      out.push_back(static_cast<std::byte>(value));
    }
    for (unsigned lane = 0; lane < lanes; ++lane) x[lane] |= 1u << 16;
    for (auto step = steps_.rbegin(); step != steps_.rend(); ++step) {
      std::uint32_t& state = x[step->lane & (lanes - 1)];
      if (step->symbol >= kPlain) {
        push(out, state, step->context, step->symbol - kPlain);
        continue;
      }
      const SymbolEnds& ends = symbols[step->context];
      const std::uint32_t count = ends.count(step->symbol);
      if (state >= std::uint64_t{count} << (32 - symbol::kProbabilityBits))
        word(out, state);
      state =
          (state / count << symbol::kProbabilityBits) + state % count + ends.first(step->symbol);
    }
    for (unsigned lane = lanes; lane-- > 1;) {
      const unsigned e = extra(x[lane]);
      const std::uint32_t mantissa = x[lane] - (1u << (16 + e));
      push(out, x[0], mantissa >> 16, e);
      push(out, x[0], mantissa & 0xFFFF, 16);
      push(out, x[0], e, 4);
    }
    const unsigned e = extra(x[0]);
    const std::uint32_t mantissa = x[0] - (1u << (16 + e));
    for (unsigned byte = headBytes(e); byte-- > 0;)
      out.push_back(static_cast<std::byte>(mantissa >> (3 + 8 * byte)));
    out.push_back(static_cast<std::byte>((lanes > 1 ? 1u : 0u) | e << 1 | (mantissa & 7) << 5));
    return out;
  }

  /// Bytes, of which the first is the last to be read, beside the one that says how many there are.
  static constexpr unsigned headBytes(unsigned e) { return (13 + e + 7) / 8; }

 private:
  static constexpr unsigned kPlain = 128;

  struct Step {
    std::uint16_t context;  // or plain bits
    std::uint8_t symbol;    // or kPlain and their number
    std::uint8_t lane;
  };

  static unsigned extra(std::uint32_t x) { return static_cast<unsigned>(std::bit_width(x)) - 17; }

  static void word(std::vector<std::byte>& out, std::uint32_t& x) {
    out.push_back(static_cast<std::byte>(x & 0xFF));
    out.push_back(static_cast<std::byte>(x >> 8 & 0xFF));
    x >>= 16;
  }

  static void push(std::vector<std::byte>& out, std::uint32_t& x, std::uint32_t value,
                   unsigned count) {
    if (x >= std::uint64_t{1} << (32 - count))
      word(out, x);
    x = x << count | value;
  }

  std::vector<Step> steps_;
  std::vector<bool> signs_;
};

/// Reads what SymbolWriter wrote. Any bytes give some symbols; reads nothing before their begin.
class SymbolReader {
 public:
  explicit SymbolReader(std::span<const std::byte> bytes)
      : bytes_(bytes.data()), left_(static_cast<std::ptrdiff_t>(bytes.size())) {
    const unsigned head = byte();
    const unsigned e = head >> 1 & 15;
    std::uint32_t mantissa = head >> 5;
    for (unsigned i = 0; i < SymbolWriter::headBytes(e); ++i) mantissa |= byte() << (3 + 8 * i);
    good_ = mantissa >> e >> 16 == 0;
    x_[0] = (1u << (16 + e)) | (mantissa & ((1u << (16 + e)) - 1));
    lanes_ = (head & 1) != 0 ? kLanes : 1;
    for (unsigned lane = 1; lane < lanes_; ++lane) {
      const unsigned more = bits(4, 0);
      const std::uint32_t low = bits(16, 0);
      x_[lane] = 1u << (16 + more) | bits(static_cast<int>(more), 0) << 16 | low;
    }
  }

  unsigned lanes() const { return lanes_; }

  /// @param lane  less than lanes()
  unsigned symbol(const SymbolEnds& ends, unsigned lane) {
    std::uint32_t& x = x_[lane];
    constexpr std::uint32_t kMask = (1u << symbol::kProbabilityBits) - 1;
    const std::uint32_t place = x & kMask;
    const unsigned s = ends.at(static_cast<int>(place));
    x = ends.count(s) * (x >> symbol::kProbabilityBits) + place - ends.first(s);
    refill(x);
    return s;
  }

  /// At most 16 bits.
  std::uint32_t bits(int count, unsigned lane) {
    std::uint32_t& x = x_[lane];
    const std::uint32_t value = x & ((1u << count) - 1);
    x >>= count;
    refill(x);
    return value;
  }

  /// Gives sign(i), 1 for negative, to visit(sign) `count` times, after the last symbol.
  template <class Visit>
  void signs(std::size_t count, const Visit& visit) {
    std::uint64_t word = 0;
    for (unsigned lane = 0; lane < lanes_; ++lane) {
      good_ = good_ && x_[lane] >> 16 == 1;
      word |= static_cast<std::uint64_t>(x_[lane] & 0xFFFF) << (16 * lane);
    }
    std::size_t have = 16 * lanes_;
    while (count > 0) {
      const std::size_t now = count < have ? count : have;
      for (std::size_t i = 0; i < now; ++i) {
        visit(static_cast<std::uint32_t>(word & 1));
        word >>= 1;
      }
      count -= now;
      have -= now;
      for (; count > 0 && have < 64 && have < count; have += 8)
        word |= static_cast<std::uint64_t>(byte()) << have;
    }
    good_ = good_ && word == 0;
  }

  void refuse() { good_ = false; }

  /// False when the string could not be one.
  bool good() const { return good_; }

  /// Bytes before the string.
  std::size_t left() const { return static_cast<std::size_t>(left_); }

 private:
  void refill(std::uint32_t& x) {
    if (x < 1u << 16) [[unlikely]]
      x = x << 16 | word();
  }

  std::uint32_t word() {
    if (left_ >= 2) [[likely]] {
      left_ -= 2;
      return static_cast<std::uint32_t>(bytes_[left_]) |
             static_cast<std::uint32_t>(bytes_[left_ + 1]) << 8;
    }
    good_ = false;
    return 0;
  }

  std::uint32_t byte() {
    if (left_ == 0) {
      good_ = false;
      return 0;
    }
    return static_cast<std::uint32_t>(bytes_[--left_]);
  }

  const std::byte* bytes_;
  std::ptrdiff_t left_;
  std::array<std::uint32_t, kLanes> x_{};
  unsigned lanes_ = 1;
  bool good_ = true;
};

}  // namespace volute
