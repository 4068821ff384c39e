// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/smoke/shared_picture.hpp"

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

/// As it travels.
struct SentRun {
  std::uint32_t pixel = 0;  ///< of the strip
  float transmittance = 1;
  std::array<float, 3> emitted{};
  double begin = 0, end = 0;
};

}  // namespace

std::vector<HeldRun> heldRuns(std::span<const Piece> pieces) {
  std::vector<HeldRun> runs;
  for (std::size_t first = 0; first < pieces.size();) {
    std::size_t end = first + 1;
    while (end < pieces.size() &&
           pieces[end].begin - pieces[end - 1].end <= kSame * std::abs(pieces[end].begin))
      ++end;
    runs.push_back({pieces[first].begin, pieces[end - 1].end,
                    composite(pieces.subspan(first, end - first))});
    first = end;
  }
  return runs;
}

void sumDepths(Team& team, std::span<float> depth) {
  for (std::size_t begin = 0; begin < depth.size(); begin += kStrip) {
    const auto strip = depth.subspan(begin, std::min(kStrip, depth.size() - begin));
    const auto all = gatherEach(team, std::span<const float>(strip));
    if (!all)
      return;
    std::vector<double> sum(strip.size());
    for (const auto& one : *all) {
      for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += one[i];
    }
    for (std::size_t i = 0; i < sum.size(); ++i) strip[i] = static_cast<float>(sum[i]);
  }
}

void composeRuns(Team& team, const std::function<std::vector<HeldRun>(std::size_t)>& runs,
                 std::span<float> rgbt) {
  const std::size_t pixels = rgbt.size() / 4;
  for (std::size_t begin = 0; begin < pixels; begin += kStrip) {
    const std::size_t count = std::min(kStrip, pixels - begin);
    std::vector<std::vector<HeldRun>> own(count);
    parallelFor(count, [&](std::size_t i) { own[i] = runs(begin + i); });
    std::vector<SentRun> sent;
    for (std::size_t i = 0; i < count; ++i) {
      for (const HeldRun& run : own[i]) {
        const auto& light = run.radiance.emitted;
        sent.push_back({static_cast<std::uint32_t>(i),
                        static_cast<float>(run.radiance.transmittance),
                        {static_cast<float>(light[0]), static_cast<float>(light[1]),
                         static_cast<float>(light[2])},
                        run.begin,
                        run.end});
      }
    }
    auto together = gatherValues(team, std::span<const SentRun>(sent));
    if (!together)
      return;
    std::ranges::stable_sort(*together, [](const SentRun& a, const SentRun& b) {
      return a.pixel != b.pixel ? a.pixel < b.pixel : a.begin < b.begin;
    });
    std::vector<Radiance> composed(count);
    std::vector<double> reached(count, -std::numeric_limits<double>::infinity());
    for (const SentRun& run : *together) {
      // A ray in the plane between two pieces is in both.
      if (run.end <= reached[run.pixel] + kSame * std::abs(run.end))
        continue;
      reached[run.pixel] = run.end;
      Radiance& pixel = composed[run.pixel];
      for (int c = 0; c < 3; ++c)
        pixel.emitted[c] += pixel.transmittance * run.emitted[static_cast<std::size_t>(c)];
      pixel.transmittance *= run.transmittance;
    }
    for (std::size_t i = 0; i < count; ++i) {
      float* const to = &rgbt[4 * (begin + i)];
      for (int c = 0; c < 3; ++c) to[c] = static_cast<float>(composed[i].emitted[c]);
      to[3] = static_cast<float>(composed[i].transmittance);
    }
  }
}

}  // namespace volute
