// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>

namespace volute {

/// IEEE 754 binary16 as files store it.
struct Half {
  std::uint16_t bits = 0;
};

/// Exact: every half is a float, NaN and infinities included.
inline float toFloat(Half half) {
  const std::uint32_t sign = static_cast<std::uint32_t>(half.bits & 0x8000u) << 16;
  const std::uint32_t exponent = half.bits >> 10 & 0x1Fu;
  const std::uint32_t mantissa = half.bits & 0x3FFu;
  std::uint32_t bits = 0;
  if (exponent == 31) {
    bits = sign | 0x7F800000u | mantissa << 13;
  } else if (exponent != 0) {
    bits = sign | (exponent + 112) << 23 | mantissa << 13;
  } else {
    const float magnitude = static_cast<float>(mantissa) * 0x1p-24f;
    return sign ? -magnitude : magnitude;
  }
  float value = 0;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

/// The nearest half, of two the even one; infinity from 65,520 on.
inline Half toHalf(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  const std::uint32_t sign = bits >> 16 & 0x8000u, size = bits & 0x7FFFFFFFu;
  constexpr std::uint32_t kInfinite = 0x7F800000u;
  std::uint32_t half = 0;
  if (size >= 0x477FF000u) {
    half = size > kInfinite ? 0x7E00u : 0x7C00u;
  } else if (size < 0x38800000u) {
    // Below the least normal half, 2^-14, halves are as far apart as floats are above a half.
    half = std::bit_cast<std::uint32_t>(std::bit_cast<float>(size) + 0.5F) -
           std::bit_cast<std::uint32_t>(0.5F);
  } else {
    half = (size - 0x38000000u + 0xFFFu + (size >> 13 & 1u)) >> 13;
  }
  return {static_cast<std::uint16_t>(sign | half)};
}

}  // namespace volute
