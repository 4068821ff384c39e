// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "volute/lighting/diffuse_light.hpp"
#include "volute/lighting/light_field.hpp"

namespace volute {

/// What shines at a medium and what is in the way. All kinds of media ask here for what surfaces
/// and other media leave of lamps' light, and for light that is scattered more than once. What a
/// medium itself takes its kind knows best: by a fan of rays, from tet to tet, from cell to cell.
struct Illumination {
  std::vector<Lamp> lamps{};
  Rgb ambient = Rgb::Zero();         ///< radiance from everywhere, whatever is in the way
  Blocks blocks{};                   ///< surfaces; may be empty
  std::vector<AnyMedium> between{};  ///< other media
  bool multiple = false;             ///< light is scattered more than once

  /// Null where light is scattered once, or no lamp shines.
  /// @param box  around the medium
  /// @param density  the medium is so many times as thick
  std::shared_ptr<const DiffuseLight> again(const AnyMedium& medium, const Box3& box,
                                            const Scattering& scattering, double density = 1) const;
};

/// What surfaces and other media leave of lamps' light at points of a box.
class ArrivingLight {
 public:
  ArrivingLight(const Illumination& light, const Box3& lit);

  /// Multiplies shares of a lamp's light, 0..1, that pass the medium itself.
  /// @param surfaces  whether they have not taken their part before
  /// @param lift  surfaces nearer to a point than this on its way are not in the way [m]
  void takeFrom(std::size_t lamp, std::span<const Vec3> points, std::span<float> shares,
                bool surfaces = true, double lift = 0) const;

  /// Whether there are any surfaces.
  bool hasSurfaces() const { return static_cast<bool>(blocks_); }

 private:
  std::vector<Lamp> lamps_;
  Blocks blocks_;
  std::vector<LightField> fields_;  ///< one for each lamp; empty: there are no other media
};

}  // namespace volute
