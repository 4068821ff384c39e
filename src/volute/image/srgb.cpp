// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/image/srgb.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "volute/base/parallel.hpp"

namespace volute {
namespace {

/// NaN gives 0.
double clampToUnit(double value) {
  return value > 0 ? std::min(value, 1.0) : 0;
}

/// The byte that shows a linear value.
std::uint8_t byteOf(double linear) {
  return static_cast<std::uint8_t>(std::lround(255 * srgbEncode(linear)));
}

/// byteOf() floats, without its power. Positive floats are in the order of their bits, so each
/// byte begins at one pattern of bits, and 2^7 parts of each octave are narrow enough that at most
/// one byte begins within each.
class SrgbTable {
 public:
  SrgbTable() {
    // begins_[0] is never asked for, and [256] never reached.
    begins_.front() = 0;
    begins_.back() = ~std::uint32_t{0};
    std::uint32_t low = kFirst;
    for (unsigned byte = 1; byte < 256; ++byte) {
      std::uint32_t high = kOne;  // shows `byte` or more; what is below `low` shows less
      while (low < high) {
        const std::uint32_t middle = low + (high - low) / 2;
        if (byteOf(std::bit_cast<float>(middle)) >= byte)
          high = middle;
        else
          low = middle + 1;
      }
      begins_[byte] = low;
    }
    for (std::size_t part = 0; part < bytes_.size(); ++part) {
      const auto bits = static_cast<std::uint32_t>(kFirst + (part << kPart));
      bytes_[part] = byteOf(std::bit_cast<float>(bits));
    }
  }

  std::uint8_t operator()(float value) const {
    // By comparisons that NaN fails; what is below the first part shows 0.
    const float clamped = value > std::bit_cast<float>(kFirst)
                              ? std::min(value, std::bit_cast<float>(kOne))
                              : std::bit_cast<float>(kFirst);
    const auto bits = std::bit_cast<std::uint32_t>(clamped);
    const unsigned byte = bytes_[(bits - kFirst) >> kPart];
    return static_cast<std::uint8_t>(byte + (bits >= begins_[byte + 1] ? 1 : 0));
  }

 private:
  static constexpr int kPart = 16;  // bits of a float that a part is not told by
  static constexpr auto kFirst = std::bit_cast<std::uint32_t>(0x1p-13F);
  static constexpr auto kOne = std::bit_cast<std::uint32_t>(1.0F);

  std::array<std::uint32_t, 257> begins_;
  std::array<std::uint8_t, ((kOne - kFirst) >> kPart) + 1> bytes_;
};

const SrgbTable& table() {
  static const SrgbTable one;
  return one;
}

}  // namespace

double srgbEncode(double linear) {
  const double v = clampToUnit(linear);
  return v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1 / 2.4) - 0.055;
}

double srgbDecode(double display) {
  const double v = clampToUnit(display);
  return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

std::uint8_t toSrgb8(float linear) {
  return table()(linear);
}

std::vector<std::uint8_t> toSrgb8(const Image& image, double exposure) {
  constexpr std::size_t kGrain = 1 << 16;
  const SrgbTable& shown = table();
  std::vector<std::uint8_t> bytes(image.pixels.size());
  const std::size_t row =
      static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.channels);
  const auto rows = static_cast<std::size_t>(image.height);
  parallelRanges(rows, kGrain / std::max<std::size_t>(row, 1) + 1,
                 [&](std::size_t first, std::size_t last) {
                   for (std::size_t y = first; y < last; ++y) {
                     const float* from = image.pixels.data() + y * row;
                     std::uint8_t* to = bytes.data() + y * row;
                     if (y > first && std::memcmp(from, from - row, row * sizeof(float)) == 0) {
                       std::copy_n(to - row, row, to);  // as in drawings
                     } else if (exposure == 1) {
                       for (std::size_t i = 0; i < row; ++i) to[i] = shown(from[i]);
                     } else {
                       for (std::size_t i = 0; i < row; ++i) to[i] = byteOf(exposure * from[i]);
                     }
                   }
                 });
  return bytes;
}

Image exposed(Image image, double factor) {
  for (float& value : image.pixels) value = static_cast<float>(value * factor);
  return image;
}

double suggestExposure(const Image& image, double share) {
  std::vector<float> lit;
  for (float value : image.pixels) {
    if (value > 0 && std::isfinite(value))
      lit.push_back(value);
  }
  if (lit.empty())
    return 1;
  const auto rank =
      static_cast<std::ptrdiff_t>(clampToUnit(share) * static_cast<double>(lit.size() - 1));
  std::nth_element(lit.begin(), lit.begin() + rank, lit.end());
  return 1 / static_cast<double>(lit[static_cast<std::size_t>(rank)]);
}

}  // namespace volute
