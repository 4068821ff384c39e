// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fog/polar_fog.hpp"

#include <algorithm>

namespace volute {

Result<PolarFog> PolarFog::make(const FogMedium& fog, const Vec3& eye,
                                const PolarOptions& options) {
  VOLUTE_ASSIGN(auto table, PolarTable::make(fog, eye, options));
  return PolarFog(fog, eye, std::move(table));
}

void PolarFog::radiance(std::span<const Segment> segments, std::span<Radiance> out) const {
  const bool fromEye = std::ranges::all_of(segments, [&](const Segment& segment) {
    return segment.origin == eye_ && segment.begin == 0 && segment.end >= 0;
  });
  if (!fromEye)
    return fog_.radiance(segments, out);
  const std::size_t count = segments.size();
  std::vector<float> lanes(5 * count);
  const std::span<float> all(lanes);
  const auto x = all.first(count), y = all.subspan(count, count);
  const auto z = all.subspan(2 * count, count), distance = all.subspan(3 * count, count);
  const auto transmittance = all.last(count);
  for (std::size_t i = 0; i < count; ++i) {
    x[i] = static_cast<float>(segments[i].direction.x());
    y[i] = static_cast<float>(segments[i].direction.y());
    z[i] = static_cast<float>(segments[i].direction.z());
    distance[i] = static_cast<float>(segments[i].end);
  }
  table_.lookUp({eye_, x, y, z, distance}, transmittance);
  std::vector<Segment> walked;
  std::vector<std::size_t> where;
  for (std::size_t i = 0; i < count; ++i) {
    if (transmittance[i] < 0)
      where.push_back(i), walked.push_back(segments[i]);
    else
      out[i] = {fog_.options().color * (1.0 - transmittance[i]), transmittance[i]};
  }
  std::vector<Radiance> exact(walked.size());
  fog_.radiance(walked, exact);
  for (std::size_t i = 0; i < where.size(); ++i) out[where[i]] = exact[i];
}

}  // namespace volute
