// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace volute {

/// 128 bits that stand for some content, in the order in which it was added: other content has
/// other bits but for chance. Not meant to withstand forgery.
class ContentHash {
 public:
  void add(std::span<const std::byte> bytes);

  /// Values without padding between or inside them.
  template <class T>
  void add(std::span<const T> values) {
    add(std::as_bytes(values));
  }

  void add(double value) { add(std::span<const double>(&value, 1)); }

  /// 32 hexadecimal digits.
  std::string digits() const;

 private:
  void mix(std::uint64_t word);

  std::uint64_t a_ = 0x9e3779b97f4a7c15, b_ = 0xc2b2ae3d27d4eb4f;
};

}  // namespace volute
