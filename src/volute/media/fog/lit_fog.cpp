// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/fog/lit_fog.hpp"

#include <algorithm>
#include <limits>

#include "volute/fog/fog_march.hpp"
#include "volute/lighting/illumination.hpp"

namespace volute {
namespace {

/// Fog whose optical depth is that of the fast path.
struct QuickFog {
  FogMedium fog;

  Box3 bounds() const { return fog.bounds(); }

  double extinction(const Vec3& point) const { return fog.extinction(point); }

  Rgb emission(const Vec3& point) const { return fog.emission(point); }

  void opticalDepth(std::span<const Segment> segments, std::span<double> depths) const {
    if (fog.hasTop())
      return fog.opticalDepth(segments, depths);
    marchDepths(fog, segments, depths, std::numeric_limits<float>::max());
  }

  void pieces(std::span<const Segment> segments, std::span<std::vector<Piece>> pieces) const {
    fog.pieces(segments, pieces);
  }
};

}  // namespace

Box3 litBox(const FogMedium& fog) {
  constexpr double kScaleHeights = 12;        // 6e-6 of an exponential is above
  constexpr double kTall = 2, kTallest = 64;  // of its width: fog without an end
  constexpr double kOpaque = 10;              // its optical depth, as far as that is near enough
  Box3 box = fog.bounds();
  const double origin = fog.domainCorner().z();
  double top = -FogProfile::kFarthest;
  for (const FogProfile::Zone& zone : fog.profile().zones()) {
    const double end = zone.decay > 0
                           ? std::max(zone.bottom, zone.reference) + kScaleHeights / zone.decay
                           : zone.top;
    top = std::max(top, std::min(end, zone.top));
  }
  const double wide = box.size().head<2>().maxCoeff();
  const auto values = fog.levels().values();
  const double densest = values.empty() ? 0 : *std::ranges::max_element(values);
  const double tall = std::clamp(kOpaque / std::max(densest, 1e-30), kTall * wide, kTallest * wide);
  box.max.z() = std::min(box.max.z(), origin + std::min(top, tall));
  box.min.z() = std::max(box.min.z(), std::min(origin, box.max.z()) - tall);
  return box;
}

namespace {

/// The way of a sun through the fog by maps of the ground, as finely as is soon done; nothing where
/// there are none.
std::shared_ptr<const KnownDepth> shadowOf(const FogMedium& fog, const Lamp& lamp) {
  constexpr int kSamples = 4, kSamplesAcross = 1024;
  if (lamp.kind != Lamp::Kind::kSun)
    return {};
  const int across = std::max({fog.levels().columns(), fog.levels().rows(), 1});
  auto maps =
      SunShadow::make(fog, -lamp.direction, std::clamp(kSamplesAcross / across, 1, kSamples));
  if (!maps)
    return {};
  return std::make_shared<const SunInFog>(std::move(*maps));
}

}  // namespace

LitMedium litFog(const FogMedium& fog, std::span<const Lamp> lamps, const FogLight& light) {
  constexpr double kFinest = 1 / 8.0;  // of a cell
  constexpr double kSunTolerance = 2e-3, kLampTolerance = 4e-3;
  const Box3 lit = litBox(fog);
  std::vector<LightField> fields;
  for (const Lamp& lamp : lamps) {
    std::vector<AnyMedium> media = light.between;
    const bool sun = lamp.kind == Lamp::Kind::kSun;
    const LightFieldOptions options{.tolerance = sun ? kSunTolerance : kLampTolerance,
                                    .finest = kFinest * fog.cell(),
                                    .known = shadowOf(fog, lamp)};
    if (!options.known)
      media.emplace_back(QuickFog{fog.finest()});
    fields.emplace_back(lamp, std::move(media), lit, options);
  }
  LitMedium::Options options{light.scattering, lit, fog.cell(), light.shadows};
  const Illumination all{.lamps = {lamps.begin(), lamps.end()},
                         .blocks = light.blocks,
                         .between = light.between,
                         .multiple = light.multiple};
  options.again = all.again(AnyMedium(QuickFog{fog.finest()}), lit, light.scattering);
  return {AnyMedium(fog), std::move(fields), std::move(options)};
}

}  // namespace volute
