// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/media/medium_kind.hpp"

// A medium that Volute does not have: what its folder holds, and one call of registerMedium(), is
// all that it takes to have another one.

namespace volute {

/// A ball whose extinction is density (1 - r^2 / R^2)^2 at a distance r from its centre, and which
/// sends back a share of the ambient light: a polynomial of degree 4 along every ray.
struct Puff {
  Vec3 centre = Vec3::Zero();  ///< [m]
  double radius = 1;           ///< R [m]
  double density = 1;          ///< [1/m], in the centre
  Rgb source = Rgb::Zero();    ///< radiance of an infinitely thick puff

  Box3 bounds() const;
  double extinction(const Vec3& point) const;

  Rgb emission(const Vec3& point) const { return extinction(point) * source; }

  void opticalDepth(std::span<const Segment> segments, std::span<double> depths) const;
  void pieces(std::span<const Segment> segments, std::span<std::vector<Piece>> pieces) const;
};

/// {"kind": "puff", "centre", "radius", "density", "albedo", "growth"}: the radius grows so fast
/// [m/s], and is stored at 0, 1 and 2 s.
const MediumKind& puffKind();

}  // namespace volute
