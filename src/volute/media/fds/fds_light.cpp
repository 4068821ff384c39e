// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/fds/fds_light.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

#include "volute/base/gather_values.hpp"
#include "volute/lighting/vertex_light.hpp"
#include "volute/media/shared_picture.hpp"

namespace volute {
namespace {

/// Of a lattice: rows of cells along x that are lit together, so that memory does not grow with it.
struct Rows {
  std::size_t lattice, begin, end;
};

/// The cells of gas in rows: their places among all cells, and their middles.
struct GasCells {
  std::vector<std::array<int, 3>> cells;
  std::vector<Vec3> middles;
};

std::vector<Rows> rowsOf(std::span<const FdsLattice> lattices, std::size_t i) {
  constexpr std::size_t kCells = 1 << 16;
  const FdsLattice& lattice = lattices[i];
  const std::size_t count = static_cast<std::size_t>(lattice.cells(1)) * lattice.cells(2);
  const std::size_t atOnce = std::max<std::size_t>(1, kCells / std::max(1, lattice.cells(0)));
  std::vector<Rows> rows;
  std::size_t begin = 0;
  do {  // none has one round of nothing
    rows.push_back({i, begin, std::min(begin + atOnce, count)});
    begin += atOnce;
  } while (begin < count);
  return rows;
}

GasCells gasOf(const FdsLattice& lattice, const std::vector<FdsCell>& states, const Rows& rows) {
  GasCells gas;
  for (std::size_t row = rows.begin; row < rows.end; ++row) {
    const auto y = static_cast<int>(row % lattice.cells(1)),
               z = static_cast<int>(row / lattice.cells(1));
    for (int x = 0; x < lattice.cells(0); ++x) {
      const std::array<int, 3> cell{x, y, z};
      if (states[lattice.cellAt(cell)] == FdsCell::kSolid)
        continue;
      Vec3 middle;
      for (int axis = 0; axis < 3; ++axis) {
        const auto& planes = lattice.planes[axis];
        const auto at = static_cast<std::size_t>(cell[axis]);
        middle[axis] = 0.5 * (planes[at] + planes[at + 1]);
      }
      gas.cells.push_back(cell);
      gas.middles.push_back(middle);
    }
  }
  return gas;
}

/// Around what this rank holds. A little larger, as outer planes that are almost the same are one.
Box3 heldBox(const FdsGrid& grid) {
  constexpr double kMargin = 1e-3;  // of its size
  Box3 box;
  for (std::size_t i = 0; i < grid.lattices().size(); ++i) {
    if (!grid.holds(i))
      continue;
    const Box3 lattice = grid.lattices()[i].bounds();
    box.extend(lattice.min);
    box.extend(lattice.max);
  }
  if (!box.empty()) {
    const Vec3 margin = kMargin * box.size();
    box = {box.min - margin, box.max + margin};
  }
  return box;
}

/// Obstructions, which stand within a case's bounds, and others.
Blocks surfacesOf(const FdsField& field, const FdsObstructions& obstructions,
                  const Blocks& others) {
  return [&field, &obstructions, &others](std::span<const Segment> ways,
                                          std::span<std::uint8_t> blocked) {
    std::vector<Segment> within(ways.begin(), ways.end());
    for (Segment& way : within) {
      const Interval inside = field.bounds().intersect(way.origin, way.direction);
      way.end = std::clamp(inside.end, 0.0, way.end);
    }
    obstructions.blocked(within, blocked);
    if (!others)
      return;
    std::vector<std::uint8_t> more(ways.size(), 0);
    others(ways, more);
    for (std::size_t i = 0; i < ways.size(); ++i) blocked[i] |= more[i];
  };
}

/// How much of a lamp's light comes to each point through the smoke.
Result<std::vector<float>> sharesOf(const FdsField& field, const FdsLamps& lamps, const Lamp& lamp,
                                    std::span<const Vec3> points) {
  std::vector<Segment> ways;
  for (const Vec3& point : points) ways.push_back(lamp.towards(point));
  std::vector<double> depths(points.size());
  if (lamps.holders) {
    const Box3 bounds = field.bounds();
    for (Segment& way : ways)
      way.end = std::clamp(bounds.intersect(way.origin, way.direction).end, 0.0, way.end);
    VOLUTE_TRY(sumAlong(
        *lamps.holders, ways, depths,
        [&](auto segments, auto out) { field.opticalDepth(segments, out); },
        heldBox(field.grid())));
  } else {
    field.opticalDepth(ways, depths);
  }
  std::vector<float> shares(points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    shares[i] = static_cast<float>(std::exp(-lamps.density * depths[i]));
  return shares;
}

/// Means at the nodes of what is known at cells.
class NodeMeans {
 public:
  explicit NodeMeans(const FdsLattice& lattice)
      : lattice_(lattice), sums_(3 * lattice.nodeCount(), 0), counts_(lattice.nodeCount(), 0) {}

  /// @param light  RGB of each cell
  void add(const GasCells& gas, std::span<const float> light) {
    const std::size_t strideY = lattice_.planes[0].size();
    const std::size_t strideZ = strideY * lattice_.planes[1].size();
    for (std::size_t i = 0; i < gas.cells.size(); ++i) {
      const auto& cell = gas.cells[i];
      const std::size_t first =
          cell[2] * strideZ + cell[1] * strideY + static_cast<std::size_t>(cell[0]);
      for (std::size_t corner = 0; corner < 8; ++corner) {
        const std::size_t node =
            first + (corner & 1) + ((corner >> 1) & 1) * strideY + (corner >> 2) * strideZ;
        ++counts_[node];
        for (std::size_t c = 0; c < 3; ++c) sums_[3 * node + c] += light[3 * i + c];
      }
    }
  }

  /// Of all that was added.
  std::shared_ptr<const FdsLight> take() {
    for (std::size_t node = 0; node < counts_.size(); ++node) {
      for (std::size_t c = 0; c < 3; ++c)
        sums_[3 * node + c] /= static_cast<float>(std::max<int>(counts_[node], 1));
    }
    return std::make_shared<const FdsLight>(std::move(sums_));
  }

 private:
  const FdsLattice& lattice_;
  FdsLight sums_;
  std::vector<std::uint8_t> counts_;
};

}  // namespace

Result<std::vector<std::shared_ptr<const FdsLight>>> fdsLight(const FdsField& field,
                                                              const FdsObstructions& obstructions,
                                                              const FdsLamps& lamps) {
  const auto lattices = field.grid().lattices();
  std::vector<Rows> all;
  for (std::size_t i = 0; i < lattices.size(); ++i) {
    if (field.grid().holds(i))
      std::ranges::copy(rowsOf(lattices, i), std::back_inserter(all));
  }
  // Ranks ask each other at once; those that have no rows left answer.
  std::uint64_t rounds = all.size();
  if (lamps.holders) {
    const std::span<const std::uint64_t> own(&rounds, 1);
    VOLUTE_ASSIGN(const auto each, gatherValues(*lamps.holders, own));
    rounds = std::ranges::max(each);
  }
  Illumination light = lamps.light;
  light.blocks = surfacesOf(field, obstructions, lamps.light.blocks);
  const ArrivingLight arriving(light, field.bounds());
  const auto again = light.again(AnyMedium(field), field.bounds(), {lamps.albedo}, lamps.density);
  std::vector<std::shared_ptr<const FdsLight>> out(lattices.size(), std::make_shared<FdsLight>());
  std::optional<NodeMeans> means;
  for (std::uint64_t round = 0; round < rounds; ++round) {
    const bool asks = round < all.size();
    GasCells gas;
    if (asks)
      gas = gasOf(lattices[all[round].lattice], field.cells(all[round].lattice), all[round]);
    std::vector<std::vector<float>> shares;
    for (std::size_t lamp = 0; lamp < light.lamps.size(); ++lamp) {
      VOLUTE_ASSIGN(auto share, sharesOf(field, lamps, light.lamps[lamp], gas.middles));
      arriving.takeFrom(lamp, gas.middles, share);
      shares.push_back(std::move(share));
    }
    if (!asks)
      continue;
    const std::size_t lattice = all[round].lattice;
    if (all[round].begin == 0)
      means.emplace(lattices[lattice]);
    means->add(gas, scatteredLight(gas.middles, light.lamps, shares, lamps.albedo, light.ambient,
                                   again.get()));
    if (round + 1 == all.size() || all[round + 1].lattice != lattice)
      out[lattice] = means->take();
  }
  return out;
}

}  // namespace volute
