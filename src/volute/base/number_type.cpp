// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/number_type.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <type_traits>

#include "volute/base/half.hpp"

namespace volute {
namespace {

/// Calls call(T()) with the type of a number in memory.
template <class Call>
auto withType(NumberKind kind, Call&& call) {
  switch (kind) {
    case NumberKind::kUint8:
      return call(std::uint8_t());
    case NumberKind::kInt8:
      return call(std::int8_t());
    case NumberKind::kUint16:
      return call(std::uint16_t());
    case NumberKind::kInt16:
      return call(std::int16_t());
    case NumberKind::kUint32:
      return call(std::uint32_t());
    case NumberKind::kInt32:
      return call(std::int32_t());
    case NumberKind::kFloat16:
      return call(Half());
    case NumberKind::kFloat64:
      return call(double());
    case NumberKind::kUint64:
      return call(std::uint64_t());
    case NumberKind::kInt64:
      return call(std::int64_t());
    case NumberKind::kBool:
      return call(bool());
    case NumberKind::kFloat32:
      break;
  }
  return call(float());
}

template <class T>
T load(const std::byte* from, bool swap) {
  if constexpr (std::is_same_v<T, bool>) {
    return *from != std::byte{0};
  } else {
    T number;
    if (swap) {
      std::array<std::byte, sizeof(T)> bytes;
      std::reverse_copy(from, from + sizeof(T), bytes.begin());
      std::memcpy(&number, bytes.data(), sizeof number);
    } else {
      std::memcpy(&number, from, sizeof number);
    }
    return number;
  }
}

template <class T>
constexpr bool kInexact = sizeof(T) >= 4 && !std::is_same_v<T, float>;

template <class T>
std::optional<double> convert(const std::byte* from, std::ptrdiff_t stride, bool swap,
                              std::span<float> to, double& rounding, double offset) {
  double maximum = 0;
  for (float& value : to) {
    const T number = load<T>(from, swap);
    from += stride;
    if constexpr (std::is_same_v<T, Half>) {
      value = toFloat(number);
    } else if (offset == 0) {
      value = static_cast<float>(number);
    }
    // 64 bits of an integer need more than a double; other differences are exact in one.
    using Wide = std::conditional_t<std::is_integral_v<T>, long double, double>;
    if (offset != 0) {
      if constexpr (std::is_same_v<T, Half>)
        value = static_cast<float>(static_cast<double>(value) - offset);
      else
        value = static_cast<float>(static_cast<Wide>(number) - static_cast<Wide>(offset));
    }
    if constexpr (kInexact<T>) {
      if (!std::isfinite(value)) {
        if (std::isfinite(static_cast<double>(number)))
          return static_cast<double>(number);
        continue;
      }
      // As a reader adds them up.
      const double shown = offset + static_cast<double>(value);
      const auto error =
          static_cast<double>(std::abs(static_cast<Wide>(number) - static_cast<Wide>(shown)));
      maximum = std::max(maximum, error);
    }
  }
  rounding = std::max(rounding, maximum);
  return std::nullopt;
}

}  // namespace

std::size_t NumberType::size() const {
  return withType(kind, [](auto number) { return sizeof number; });
}

bool NumberType::isFloat() const {
  return kind == NumberKind::kFloat32 && bigEndian == (std::endian::native == std::endian::big);
}

std::optional<NumberType> numberTypeOf(std::string_view code) {
  using enum NumberKind;
  static constexpr std::pair<std::string_view, NumberKind> kCodes[] = {
      {"u1", kUint8},   {"i1", kInt8},   {"u2", kUint16},  {"i2", kInt16},
      {"u4", kUint32},  {"i4", kInt32},  {"f2", kFloat16}, {"f4", kFloat32},
      {"f8", kFloat64}, {"u8", kUint64}, {"i8", kInt64},   {"b1", kBool}};
  if (code.size() != 3)
    return std::nullopt;
  const auto* found =
      std::ranges::find(kCodes, code.substr(1), &std::pair<std::string_view, NumberKind>::first);
  if (found == std::end(kCodes))
    return std::nullopt;
  NumberType type{found->second, code[0] == '>'};
  const bool single = type.size() == 1;
  constexpr bool kBig = std::endian::native == std::endian::big;
  switch (code[0]) {
    case '<':
    case '>':
      break;
    case '=':
      type.bigEndian = kBig;
      break;
    case '|':
      if (!single)
        return std::nullopt;
      break;
    default:
      return std::nullopt;
  }
  if (single)
    type.bigEndian = false;
  return type;
}

std::optional<double> toFloats(const NumberType& type, const std::byte* from, std::ptrdiff_t stride,
                               std::span<float> to, double& rounding, double offset) {
  const bool swap = type.bigEndian != (std::endian::native == std::endian::big);
  return withType(type.kind, [&](auto number) {
    return convert<decltype(number)>(from, stride, swap, to, rounding, offset);
  });
}

}  // namespace volute
