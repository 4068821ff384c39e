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

/// The box of all cells that have a value above 0, or corners that have; empty if none has.
Box3 litBounds(const FdsField& light) {
  Box3 box;
  for (std::size_t i = 0; i < light.grid().lattices().size(); ++i) {
    const FdsLattice& lattice = light.grid().lattices()[i];
    const auto& values = light.values(i).value;
    const int extra = lattice.nodal ? 1 : 0;
    std::size_t place = 0;
    for (int z = 0; z < lattice.cells(2) + extra; ++z) {
      for (int y = 0; y < lattice.cells(1) + extra; ++y) {
        for (int x = 0; x < lattice.cells(0) + extra; ++x) {
          if (!(values[place++] > 0))
            continue;
          const std::array<int, 3> at{x, y, z};
          for (int axis = 0; axis < 3; ++axis) {
            // A node lights the cells on both sides of it.
            const auto& planes = lattice.planes[axis];
            const int last = static_cast<int>(planes.size()) - 1;
            box.min[axis] = std::min(box.min[axis], planes[std::max(at[axis] - extra, 0)]);
            box.max[axis] = std::max(box.max[axis], planes[std::min(at[axis] + 1, last)]);
          }
        }
      }
    }
  }
  return box;
}

Rgb colourOf(const FlameLaw& law) {
  const auto [r, g, b] = blackBodyColour(law.temperature);
  return kPerMegawatt * law.emission * Rgb(r, g, b);
}

}  // namespace

FdsFlame::FdsFlame(const FdsField& heat, const FlameLaw& law)
    : light_(above(heat, law.cutoff)), colour_(colourOf(law)), bounds_(litBounds(light_)) {
  burns_ = !bounds_.empty();
  if (!burns_)
    bounds_ = light_.bounds();
}

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
