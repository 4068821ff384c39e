// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "volute/fog/fog_medium.hpp"
#include "volute/fog/sun_shadow.hpp"
#include "volute/lighting/lit_medium.hpp"

namespace volute {

/// What stands in the light of lamps that shine at a fog, and what it does with it.
struct FogLight {
  Scattering scattering{};
  ShadowsOn shadows{};               ///< may be empty
  std::vector<AnyMedium> between{};  ///< other media, with their physical extinction
  Blocks blocks{};                   ///< the same surfaces; may be empty
  bool multiple = false;             ///< light is scattered more than once
};

/// A box outside of which a fog is too thin to be lit; finite.
Box3 litBox(const FogMedium& fog);

/// The way of a sun through a fog.
struct SunInFog final : KnownDepth {
  SunShadow maps;

  explicit SunInFog(SunShadow made) : maps(std::move(made)) {}

  double opticalDepth(const Vec3& point) const override { return maps.opticalDepth(point); }

  void shares(std::span<const Vec3> points, std::span<double> shares) const override {
    maps.shares(points, shares);
  }
};

/// Fog in the light of lamps that reach it through itself and other media.
LitMedium litFog(const FogMedium& fog, std::span<const Lamp> lamps, const FogLight& light);

}  // namespace volute
