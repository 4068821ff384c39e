// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/lighting/illumination.hpp"

#include "volute/base/parallel.hpp"

namespace volute {

std::shared_ptr<const DiffuseLight> Illumination::again(const AnyMedium& medium, const Box3& box,
                                                        const Scattering& scattering,
                                                        double density) const {
  if (!multiple || lamps.empty())
    return nullptr;
  return std::make_shared<const DiffuseLight>(DiffuseLight::Request{.medium = medium,
                                                                    .box = box,
                                                                    .scattering = scattering,
                                                                    .lamps = lamps,
                                                                    .between = between,
                                                                    .blocks = blocks,
                                                                    .density = density});
}

ArrivingLight::ArrivingLight(const Illumination& light, const Box3& lit)
    : lamps_(light.lamps), blocks_(light.blocks) {
  for (const Lamp& lamp : light.lamps) {
    if (!light.between.empty())
      fields_.emplace_back(lamp, light.between, lit);
  }
}

void ArrivingLight::takeFrom(std::size_t lamp, std::span<const Vec3> points,
                             std::span<float> shares, bool surfaces, double lift) const {
  constexpr std::size_t kTogether = 512;
  const bool blocks = surfaces && blocks_;
  if (!blocks && fields_.empty())
    return;
  parallelRanges(points.size(), kTogether, [&](std::size_t begin, std::size_t end) {
    std::vector<std::size_t> lit;
    std::vector<Segment> ways;
    for (std::size_t i = begin; i < end; ++i) {
      if (shares[i] > 0)
        lit.push_back(i), ways.push_back(lamps_[lamp].towards(points[i])), ways.back().begin = lift;
    }
    std::vector<std::uint8_t> blocked(ways.size(), 0);
    if (blocks && !ways.empty())
      blocks_(ways, blocked);
    for (std::size_t k = 0; k < lit.size(); ++k) {
      float& share = shares[lit[k]];
      if (blocked[k])
        share = 0;
      else if (!fields_.empty())
        share *= static_cast<float>(fields_[lamp].at(points[lit[k]]).share);
    }
  });
}

}  // namespace volute
