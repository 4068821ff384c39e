// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace volute {

enum class NumberKind {
  kUint8,
  kInt8,
  kUint16,
  kInt16,
  kUint32,
  kInt32,
  kFloat16,
  kFloat32,
  kFloat64,
  kUint64,
  kInt64,
  kBool,
};

/// How numbers lie in files and in the arrays of other programs.
struct NumberType {
  NumberKind kind = NumberKind::kFloat32;
  bool bigEndian = false;

  std::size_t size() const;  ///< [bytes]

  /// Floats as they are in memory: nothing is to be converted.
  bool isFloat() const;

  /// Whether a float may be another number: 32 bits of an integer, or 64 of anything.
  bool isRounded() const { return size() >= 4 && kind != NumberKind::kFloat32; }

  bool operator==(const NumberType&) const = default;
};

/// NumPy's code of a type: "<f8", "|u1", ">i2", "|b1"; nothing for what is no real number, or has
/// no fixed size.
std::optional<NumberType> numberTypeOf(std::string_view code);

/// Converts to.size() numbers, `stride` bytes apart and aligned anyhow, to the nearest floats.
/// Returns the first finite number that is beyond all floats; nothing: there is none.
/// @param rounding  raised to the largest |offset + float - number| of these
/// @param offset    taken off each number before
[[nodiscard]] std::optional<double> toFloats(const NumberType& type, const std::byte* from,
                                             std::ptrdiff_t stride, std::span<float> to,
                                             double& rounding, double offset = 0);

}  // namespace volute
