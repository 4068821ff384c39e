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

/// The pixels of a channel that read its largest value, where that is a limit.
std::vector<char> fullOf(const Image& image, std::size_t channel, float largest) {
  constexpr std::size_t kFewest = 12, kTimes = 8, kFewestValues = 8;
  constexpr double kShare = 0.01, kLit = 0.05;
  const std::size_t pixels = image.pixels.size() / 3;
  std::vector<char> is(pixels);
  std::vector<char> read(kLargest + 1);
  std::size_t lit = 0, full = 0, others = 0;
  for (std::size_t i = 0; i < pixels; ++i) {
    const float value = image.pixels[3 * i + channel];
    lit += value > kLit * largest ? 1 : 0;
    is[i] = value == largest ? 1 : 0;
    full += is[i] != 0 ? 1 : 0;
    if (value < largest && value > 0.5F * largest) {
      ++others;
      read[static_cast<std::size_t>(std::lround(value / largest * kLargest))] = 1;
    }
  }
  const auto values = static_cast<std::size_t>(std::ranges::count(read, 1));
  if (values < kFewestValues || full < kFewest || full * values < kTimes * others ||
      static_cast<double>(full) < kShare * static_cast<double>(lit))
    return {};
  return is;
}

/// Whether all lit values are whole steps, but for rounding; of a dozen lit ones at least.
bool areSteps(const Image& floats, double step, double tolerance) {
  constexpr std::size_t kFewest = 50;
  std::size_t lit = 0;
  for (const float value : floats.pixels) {
    if (!std::isfinite(value) || value == 0)
      continue;
    const double steps = value / step;
    if (!(steps > 0) || std::abs(steps - std::round(steps)) > tolerance)
      return false;
    ++lit;
  }
  return lit >= kFewest;
}

}  // namespace

std::optional<std::array<double, 3>> channelLimits(const Image& image, double limit) {
  if (image.channels != 3 || image.pixels.empty())
    return std::nullopt;
  std::array<float, 3> most{};
  for (std::size_t i = 0; i < image.pixels.size(); ++i)
    most[i % 3] = std::max(most[i % 3], image.pixels[i]);
  if (most[0] == most[1] && most[1] == most[2])
    return std::nullopt;
  std::array<std::vector<char>, 3> full;
  for (std::size_t c = 0; c < 3; ++c) {
    if (most[c] > 0)
      full[c] = fullOf(image, c, most[c]);
  }
  std::array<double, 3> limits{limit, limit, limit};
  bool any = false;
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = 0; b < 3; ++b) {
      if (a == b || full[a].empty() || full[b].empty())
        continue;
      std::size_t both = 0;
      for (std::size_t i = 0; i < full[a].size(); ++i) both += full[a][i] & full[b][i];
      const auto fewer = std::min(std::ranges::count(full[a], 1), std::ranges::count(full[b], 1));
      if (2 * both < static_cast<std::size_t>(fewer))
        continue;
      limits[a] = std::min(limit, static_cast<double>(most[a]));
      any = any || limits[a] < limit;
    }
  }
  return any ? std::optional(limits) : std::nullopt;
}

double countsOf(const Image& floats) {
  constexpr float kFewestCounts = 15;
  if (floats.pixels.empty() || !areSteps(floats, 1, 0))
    return 0;
  float most = 0;
  for (const float value : floats.pixels)
    most = std::isfinite(value) ? std::max(most, value) : most;
  return most > kFewestCounts && most <= kLargest ? most : 0;
}

bool areDividedIntegers(const Image& floats) {
  if (std::ranges::any_of(floats.pixels, [](float value) { return value > 1; }))
    return false;
  // As half floats have them, and as floats do.
  return areSteps(floats, 1.0 / 255, 0.1) || areSteps(floats, 1.0 / kLargest, 0.02);
}

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
