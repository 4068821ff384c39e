// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/fds_flame.hpp"

#include <algorithm>

#include "volute/optics/black_body.hpp"

namespace volute {
namespace {

constexpr double kPerMegawatt = 1e-3;  // of kW

FdsField above(const FdsField& heat, double cutoff) {
  std::vector<std::shared_ptr<const FdsValues>> values;
  for (std::size_t i = 0; i < heat.grid().lattices().size(); ++i) {
    auto cut = std::make_shared<FdsValues>();
    cut->value = heat.values(i).value;
    for (float& value : cut->value) {
      // NaN stays: it marks what no gas needs.
      if (value < static_cast<float>(cutoff))
        value = 0;
    }
    values.push_back(std::move(cut));
  }
  return heat.withValues(std::move(values));
}

Rgb colourOf(const FlameLaw& law) {
  const auto [r, g, b] = blackBodyColour(law.temperature);
  return kPerMegawatt * law.emission * Rgb(r, g, b);
}

}  // namespace

FdsFlame::FdsFlame(const FdsField& heat, const FlameLaw& law)
    : light_(above(heat, law.cutoff)), colour_(colourOf(law)) {}

void FdsFlame::opticalDepth(std::span<const Segment> segments, std::span<double> depths) const {
  std::fill_n(depths.begin(), segments.size(), 0.0);
}

void FdsFlame::pieces(std::span<const Segment> segments,
                      std::span<std::vector<Piece>> pieces) const {
  light_.pieces(segments, pieces);
  for (std::vector<Piece>& list : pieces) {
    std::erase_if(list, [](const Piece& piece) {
      return std::ranges::all_of(piece.extinction.c, [](double c) { return c == 0; });
    });
    for (Piece& piece : list) {
      for (int c = 0; c < 3; ++c) piece.emission[c] = piece.extinction * colour_[c];
      piece.extinction = {};
    }
  }
}

void FdsFlame::radiance(std::span<const Segment> segments, std::span<Radiance> out) const {
  std::vector<double> heat(segments.size());
  light_.opticalDepth(segments, heat);
  for (std::size_t i = 0; i < segments.size(); ++i) out[i] = {colour_ * heat[i], 1};
}

}  // namespace volute
