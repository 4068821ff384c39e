// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/shared_picture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "volute/base/gather_values.hpp"
#include "volute/base/parallel.hpp"
#include "volute/medium/integrate.hpp"

namespace volute {
namespace {

/// Pixels that are exchanged together: bounds what ranks hold of each other's.
constexpr std::size_t kStrip = std::size_t{1} << 16;

/// A gap between pieces that rounding makes, relative to where it is.
constexpr double kSame = 1e-9;

/// A strip's pixels, of which each rank owns a band.
struct Bands {
  Bands(std::size_t pixels, const Team& team)
      : count(pixels), ranks(static_cast<std::size_t>(team.size())) {}

  std::size_t begin(int rank) const { return count * static_cast<std::size_t>(rank) / ranks; }

  std::size_t ofRank(int rank) const { return begin(rank + 1) - begin(rank); }

  std::size_t count, ranks;
};

/// As it travels.
struct SentRun {
  SentRun() = default;

  SentRun(std::size_t place, const HeldRun& run)
      : pixel(static_cast<std::uint32_t>(place)),
        transmittance(static_cast<float>(run.radiance.transmittance)),
        begin(run.begin),
        end(run.end) {
    for (std::size_t c = 0; c < 3; ++c) emitted[c] = static_cast<float>(run.radiance.emitted[c]);
  }

  std::uint32_t pixel = 0;  ///< of the owner's band
  float transmittance = 1;
  std::array<float, 3> emitted{};
  double begin = 0, end = 0;
};

/// RGBT of `pixels` pixels, of runs from all ranks.
std::vector<float> composed(std::span<const std::vector<SentRun>> received, std::size_t pixels) {
  std::vector<SentRun> runs;
  for (const auto& one : received) runs.insert(runs.end(), one.begin(), one.end());
  std::ranges::stable_sort(runs, [](const SentRun& a, const SentRun& b) {
    return a.pixel != b.pixel ? a.pixel < b.pixel : a.begin < b.begin;
  });
  std::vector<Radiance> whole(pixels);
  std::vector<double> reached(pixels, -std::numeric_limits<double>::infinity());
  for (const SentRun& run : runs) {
    // A ray in the plane between two pieces is in both.
    if (run.end <= reached[run.pixel] + kSame * std::abs(run.end))
      continue;
    reached[run.pixel] = run.end;
    Radiance& pixel = whole[run.pixel];
    for (int c = 0; c < 3; ++c)
      pixel.emitted[c] += pixel.transmittance * run.emitted[static_cast<std::size_t>(c)];
    pixel.transmittance *= run.transmittance;
  }
  std::vector<float> rgbt;
  rgbt.reserve(4 * pixels);
  for (const Radiance& pixel : whole) {
    for (int c = 0; c < 3; ++c) rgbt.push_back(static_cast<float>(pixel.emitted[c]));
    rgbt.push_back(static_cast<float>(pixel.transmittance));
  }
  return rgbt;
}

/// Each owner adds up its band, and all get the sums.
template <class Value>
void sumInOrder(Team& team, std::span<Value> values) {
  for (std::size_t begin = 0; begin < values.size(); begin += kStrip) {
    const auto strip = values.subspan(begin, std::min(kStrip, values.size() - begin));
    const Bands bands(strip.size(), team);
    std::vector<std::vector<Value>> toOwners;
    for (int rank = 0; rank < team.size(); ++rank) {
      const auto band = strip.subspan(bands.begin(rank), bands.ofRank(rank));
      toOwners.emplace_back(band.begin(), band.end());
    }
    const auto received = exchangeValues(team, std::span<const std::vector<Value>>(toOwners));
    if (!received)
      return;
    std::vector<double> sum(bands.ofRank(team.rank()));
    for (const auto& one : *received) {
      for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += one[i];
    }
    const std::vector<Value> own(sum.begin(), sum.end());
    const auto all = gatherValues(team, std::span<const Value>(own));
    if (!all)
      return;
    std::ranges::copy(*all, strip.begin());
  }
}

}  // namespace

std::vector<HeldRun> heldRuns(std::span<const std::vector<Piece>> perMedium) {
  std::vector<Interval> stretches;
  for (const auto& pieces : perMedium) {
    for (const Piece& piece : pieces) stretches.push_back({piece.begin, piece.end});
  }
  std::ranges::sort(stretches, {}, &Interval::begin);
  std::vector<HeldRun> runs;
  for (const Interval& stretch : stretches) {
    if (!runs.empty() && stretch.begin - runs.back().end <= kSame * std::abs(stretch.begin))
      runs.back().end = std::max(runs.back().end, stretch.end);
    else
      runs.push_back({stretch.begin, stretch.end, {}});
  }
  std::vector<std::size_t> next(perMedium.size(), 0);
  std::vector<std::vector<Piece>> within(perMedium.size());
  for (HeldRun& run : runs) {
    for (std::size_t m = 0; m < perMedium.size(); ++m) {
      within[m].clear();
      while (next[m] < perMedium[m].size() && perMedium[m][next[m]].begin < run.end)
        within[m].push_back(perMedium[m][next[m]++]);
    }
    run.radiance = within.size() == 1 ? composite(within[0]) : compositeMedia(within);
  }
  return runs;
}

void sumDepths(Team& team, std::span<float> depth) {
  sumInOrder(team, depth);
}

void sumDepths(Team& team, std::span<double> depth) {
  sumInOrder(team, depth);
}

void composeRuns(Team& team, const std::function<std::vector<HeldRun>(std::size_t)>& runs,
                 std::span<float> rgbt) {
  const std::size_t pixels = rgbt.size() / 4;
  for (std::size_t begin = 0; begin < pixels; begin += kStrip) {
    const Bands bands(std::min(kStrip, pixels - begin), team);
    std::vector<std::vector<HeldRun>> own(bands.count);
    parallelFor(bands.count, [&](std::size_t i) { own[i] = runs(begin + i); });
    std::vector<std::vector<SentRun>> toOwners;
    for (int rank = 0; rank < team.size(); ++rank) {
      auto& sent = toOwners.emplace_back();
      for (std::size_t i = bands.begin(rank); i < bands.begin(rank + 1); ++i) {
        for (const HeldRun& run : own[i]) sent.emplace_back(i - bands.begin(rank), run);
      }
    }
    const auto received = exchangeValues(team, std::span<const std::vector<SentRun>>(toOwners));
    if (!received)
      return;
    const auto finished =
        gatherValues(team, std::span<const float>(composed(*received, bands.ofRank(team.rank()))));
    if (!finished)
      return;
    std::ranges::copy(*finished, rgbt.begin() + static_cast<std::ptrdiff_t>(4 * begin));
  }
}

}  // namespace volute
