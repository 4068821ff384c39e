// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/capture/stored_values.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

namespace volute {
namespace {

constexpr int kLargest = 65535;  // of 16 bits

bool isOfBytes(const Image& image, double largest) {
  return largest <= kLargest && std::ranges::all_of(image.pixels, [](float value) {
           return std::lround(value * kLargest) % 257 == 0;
         });
}

}  // namespace

std::optional<StoredPlateau> plateauOf(const Image& image, double largestOfFile) {
  constexpr std::size_t kFewest = 12, kTimes = 8, kFewestValues = 8;
  constexpr double kShare = 0.01, kLit = 0.05;
  if (image.pixels.empty())
    return std::nullopt;
  const float largest = *std::ranges::max_element(image.pixels);
  if (!(largest > 0) || !(largest < 1 - 0.5F / kLargest))
    return std::nullopt;
  const auto channels = static_cast<std::size_t>(image.channels);
  // Of more bits the picture's own range counts.
  const double steps =
      largestOfFile > kLargest ? kLargest / static_cast<double>(largest) : kLargest;
  std::vector<std::uint32_t> counts(kLargest + 1);
  std::size_t lit = 0, full = 0;
  for (std::size_t i = 0; i < image.pixels.size(); i += channels) {
    const float most = *std::max_element(&image.pixels[i], &image.pixels[i] + channels);
    lit += most > kLit * largest ? 1 : 0;
    full += most == largest ? 1 : 0;
    if (most < largest && most > 0.5F * largest)
      ++counts[static_cast<std::size_t>(std::lround(most * steps))];
  }
  // Of 8 bits only what is near white is likely to be a limit: 235 of 255 of films.
  constexpr float kNearWhite = 0.85F;
  if (largest < kNearWhite && isOfBytes(image, largestOfFile))
    return std::nullopt;
  const auto values = static_cast<std::size_t>(
      std::ranges::count_if(counts, [](std::uint32_t count) { return count > 0; }));
  std::size_t others = 0;
  for (const std::uint32_t count : counts) others += count;
  if (values < kFewestValues || full < kFewest || full * values < kTimes * others ||
      static_cast<double>(full) < kShare * static_cast<double>(lit))
    return std::nullopt;
  return StoredPlateau{largest, static_cast<double>(full) / static_cast<double>(lit)};
}

int bitsHolding(const Image& image, double largest) {
  if (image.pixels.empty() || largest < kLargest || isOfBytes(image, largest))
    return 0;
  const auto most = std::llround(*std::ranges::max_element(image.pixels) * largest);
  return std::bit_width(static_cast<std::uint64_t>(std::max(most, 0LL)));
}

std::optional<int> bitsOf(double value, double largest) {
  const auto stored = std::llround(value * largest);
  for (int bits = 9; std::ldexp(1.0, bits) - 1 < largest; ++bits) {
    if (stored == (1LL << bits) - 1)
      return bits;
  }
  return std::nullopt;
}

bool isMosaic(const Image& image) {
  constexpr double kLit = 0.1, kApart = 1.2;
  constexpr std::size_t kFewest = 25;
  if (image.pixels.empty() || image.channels != 1)
    return false;
  const float largest = *std::ranges::max_element(image.pixels);
  std::array<double, 4> sum{};
  std::size_t blocks = 0;
  for (int y = 0; y + 1 < image.height; y += 2) {
    for (int x = 0; x + 1 < image.width; x += 2) {
      const std::array<float, 4> block{image.at(x, y), image.at(x + 1, y), image.at(x, y + 1),
                                       image.at(x + 1, y + 1)};
      const float most = std::ranges::max(block);
      if (!(most > kLit * largest) || most == largest)
        continue;
      ++blocks;
      for (std::size_t i = 0; i < block.size(); ++i) sum[i] += block[i];
    }
  }
  const auto [least, most] = std::ranges::minmax(sum);
  return blocks >= kFewest && most > kApart * least;
}

}  // namespace volute
