// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/fds/lit_fds.hpp"

#include <algorithm>
#include <limits>

#include "volute/media/light_blockers.hpp"
#include "volute/media/shared_picture.hpp"
#include "volute/render/scaled_medium.hpp"

namespace volute {
namespace {

/// The mean length of the finest lattice's cells on the axis where they are shortest [m].
double cellOf(const FdsGrid& grid) {
  double cell = std::numeric_limits<double>::infinity();
  for (const FdsLattice& lattice : grid.lattices()) {
    const Vec3 size = lattice.bounds().size();
    for (int axis = 0; axis < 3; ++axis) cell = std::min(cell, size[axis] / lattice.cells(axis));
  }
  return cell;
}

}  // namespace

LitMedium litFds(const FdsField& field, const FdsLamps& lamps) {
  constexpr double kFinest = 0.5, kStep = 0.6;  // of a cell
  const Illumination& light = lamps.light;
  const FdsField smoke = field.withSource(lamps.albedo * light.ambient);
  const double cell = cellOf(field.grid());
  const Box3 box = field.bounds();
  const LightFieldOptions options{.finest = kFinest * cell};
  std::vector<AnyMedium> media = light.between;
  media.push_back(scaledBy(lamps.density, AnyMedium(smoke)));
  std::vector<LightField> fields;
  for (const Lamp& lamp : light.lamps) {
    if (!lamps.team) {
      fields.emplace_back(lamp, media, box, options);
      continue;
    }
    fields.emplace_back(lamp, media, box, options,
                        [&](std::span<const Segment> ways, std::span<double> depths) {
                          media.back().opticalDepth(ways, depths);
                          sumDepths(*lamps.team, depths);
                        });
  }
  LitMedium::Options lit{{lamps.albedo, 0}, box, kStep * cell, shadowsOf(lamps.surfaces)};
  lit.again = light.again(AnyMedium(smoke), box, lit.scattering, lamps.density);
  return {AnyMedium(smoke), std::move(fields), std::move(lit)};
}

}  // namespace volute
