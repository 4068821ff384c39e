// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/fds/fds_light.hpp"

#include <algorithm>
#include <cmath>

#include "volute/base/gather_values.hpp"
#include "volute/lighting/vertex_light.hpp"
#include "volute/media/smoke/shared_picture.hpp"

namespace volute {
namespace {

/// The cells of gas of a lattice: their places among all cells, and their middles.
struct GasCells {
  std::vector<std::array<int, 3>> cells;
  std::vector<Vec3> middles;
};

GasCells gasOf(const FdsLattice& lattice, const std::vector<FdsCell>& states) {
  GasCells gas;
  for (int z = 0; z < lattice.cells(2); ++z) {
    for (int y = 0; y < lattice.cells(1); ++y) {
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
  }
  return gas;
}

/// How much of a lamp's light comes to each point.
Result<std::vector<float>> sharesOf(const FdsField& field, const FdsObstructions& obstructions,
                            const FdsLamps& lamps, const Lamp& lamp, std::span<const Vec3> points) {
  const Box3 bounds = field.bounds();
  std::vector<Segment> ways;
  for (const Vec3& point : points) {
    Segment way = lamp.towards(point);
    // What stands in the way stands within the case's bounds.
    if (std::isinf(way.end))
      way.end = std::max(0.0, bounds.intersect(way.origin, way.direction).end);
    ways.push_back(way);
  }
  std::vector<double> depths(points.size());
  std::vector<std::uint8_t> hidden(points.size(), 0);
  std::vector<std::uint8_t> others(points.size(), 0);
  if (lamps.holders) {
    VOLUTE_TRY(sumAlong(*lamps.holders, ways, depths, [&](auto segments, auto out) {
      field.opticalDepth(segments, out);
    }));
  } else {
    field.opticalDepth(ways, depths);
  }
  obstructions.blocked(ways, hidden);
  if (lamps.blocks) {
    for (std::size_t i = 0; i < ways.size(); ++i) ways[i] = lamp.towards(points[i]);
    lamps.blocks(ways, others);
  }
  std::vector<float> shares(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    shares[i] = hidden[i] != 0 || others[i] != 0
                    ? 0.0F
                    : static_cast<float>(std::exp(-lamps.density * depths[i]));
  }
  return shares;
}

/// Means at the nodes of what is known at cells.
FdsLight atNodes(const FdsLattice& lattice, const GasCells& gas, std::span<const float> light) {
  const std::size_t strideY = lattice.planes[0].size();
  const std::size_t strideZ = strideY * lattice.planes[1].size();
  FdsLight nodes(3 * lattice.nodeCount(), 0);
  std::vector<std::uint8_t> counts(lattice.nodeCount(), 0);
  for (std::size_t i = 0; i < gas.cells.size(); ++i) {
    const auto& cell = gas.cells[i];
    const std::size_t first =
        cell[2] * strideZ + cell[1] * strideY + static_cast<std::size_t>(cell[0]);
    for (std::size_t corner = 0; corner < 8; ++corner) {
      const std::size_t node =
          first + (corner & 1) + ((corner >> 1) & 1) * strideY + (corner >> 2) * strideZ;
      ++counts[node];
      for (std::size_t c = 0; c < 3; ++c) nodes[3 * node + c] += light[3 * i + c];
    }
  }
  for (std::size_t node = 0; node < counts.size(); ++node) {
    for (std::size_t c = 0; c < 3; ++c)
      nodes[3 * node + c] /= static_cast<float>(std::max<int>(counts[node], 1));
  }
  return nodes;
}

}  // namespace

Result<std::vector<std::shared_ptr<const FdsLight>>> fdsLight(const FdsField& field,
                                                               const FdsObstructions& obstructions,
                                                               const FdsLamps& lamps) {
  const auto lattices = field.grid().lattices();
  std::vector<std::size_t> held;
  for (std::size_t i = 0; i < lattices.size(); ++i) {
    if (field.grid().holds(i))
      held.push_back(i);
  }
  // Ranks ask each other at once; those that have no lattice left answer.
  std::uint64_t rounds = held.size();
  if (lamps.holders) {
    const std::span<const std::uint64_t> own(&rounds, 1);
    VOLUTE_ASSIGN(const auto each, gatherValues(*lamps.holders, own));
    rounds = std::ranges::max(each);
  }
  std::vector<std::shared_ptr<const FdsLight>> out(lattices.size(), std::make_shared<FdsLight>());
  for (std::uint64_t round = 0; round < rounds; ++round) {
    const bool asks = round < held.size();
    const std::size_t i = asks ? held[round] : 0;
    const GasCells gas = asks ? gasOf(lattices[i], field.cells(i)) : GasCells();
    std::vector<std::vector<float>> shares;
    for (const Lamp& lamp : lamps.lamps) {
      VOLUTE_ASSIGN(auto share, sharesOf(field, obstructions, lamps, lamp, gas.middles));
      shares.push_back(std::move(share));
    }
    if (!asks)
      continue;
    const auto light =
        scatteredLight(gas.middles, lamps.lamps, shares, lamps.albedo, lamps.ambient);
    out[i] = std::make_shared<const FdsLight>(atNodes(lattices[i], gas, light));
  }
  return out;
}

}  // namespace volute
