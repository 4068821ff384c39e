// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace volute {

/// Appends the little-endian numbers of docs/format.md to a byte string.
class ByteWriter {
 public:
  void u8(std::uint8_t value) { bytes_.push_back(static_cast<std::byte>(value)); }

  void u16(std::uint16_t value) { fixed(value, 2); }

  void u32(std::uint32_t value) { fixed(value, 4); }

  void u64(std::uint64_t value) { fixed(value, 8); }

  void f64(double value) { fixed(std::bit_cast<std::uint64_t>(value), 8); }

  void f32(float value) { fixed(std::bit_cast<std::uint32_t>(value), 4); }

  void varint(std::uint64_t value) {
    for (; value >= 0x80; value >>= 7) u8(static_cast<std::uint8_t>(value | 0x80));
    u8(static_cast<std::uint8_t>(value));
  }

  void zigzag(std::int64_t value) {
    varint(static_cast<std::uint64_t>(value) << 1 ^ static_cast<std::uint64_t>(value >> 63));
  }

  void bytes(std::span<const std::byte> data) {
    bytes_.insert(bytes_.end(), data.begin(), data.end());
  }

  void string(std::string_view text) {
    varint(text.size());
    bytes(std::as_bytes(std::span(text)));
  }

  std::size_t size() const { return bytes_.size(); }

  std::span<const std::byte> view() const { return bytes_; }

  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  void fixed(std::uint64_t value, int count) {
    for (int i = 0; i < count; ++i) u8(static_cast<std::uint8_t>(value >> 8 * i));
  }

  std::vector<std::byte> bytes_;
};

/// Reads what ByteWriter wrote. Reading past the end, or a malformed varint, gives zeros and makes
/// ok() false for good: a parser reads a group of fields and asks once. Loops over counts that the
/// bytes state must ask each time.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  bool ok() const { return ok_; }

  std::size_t remaining() const { return bytes_.size(); }

  std::uint8_t u8() { return static_cast<std::uint8_t>(fixed(1)); }

  std::uint16_t u16() { return static_cast<std::uint16_t>(fixed(2)); }

  std::uint32_t u32() { return static_cast<std::uint32_t>(fixed(4)); }

  std::uint64_t u64() { return fixed(8); }

  double f64() { return std::bit_cast<double>(fixed(8)); }

  float f32() { return std::bit_cast<float>(static_cast<std::uint32_t>(fixed(4))); }

  std::uint64_t varint() {
    std::uint64_t value = 0;
    for (int shift = 0; shift < 70; shift += 7) {
      const std::uint64_t byte = u8();
      if (shift == 63 && byte > 1)
        break;
      value |= (byte & 0x7F) << shift;
      if (byte < 0x80)
        return value;
    }
    fault();
    return 0;
  }

  std::int64_t zigzag() {
    const std::uint64_t value = varint();
    return static_cast<std::int64_t>(value >> 1 ^ (~(value & 1) + 1));
  }

  std::span<const std::byte> bytes(std::uint64_t count) {
    if (count > bytes_.size()) {
      fault();
      return {};
    }
    const auto part = bytes_.first(static_cast<std::size_t>(count));
    bytes_ = bytes_.subspan(part.size());
    return part;
  }

  std::string string() {
    const auto part = bytes(varint());
    return {reinterpret_cast<const char*>(part.data()), part.size()};
  }

 private:
  std::uint64_t fixed(int count) {
    const auto part = bytes(static_cast<std::uint64_t>(count));
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < part.size(); ++i) {
      value |= static_cast<std::uint64_t>(part[i]) << 8 * i;
    }
    return value;
  }

  void fault() {
    ok_ = false;
    bytes_ = {};
  }

  std::span<const std::byte> bytes_;
  bool ok_ = true;
};

}  // namespace volute
