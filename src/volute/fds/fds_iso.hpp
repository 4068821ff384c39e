// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>

#include "volute/fds/fds_field.hpp"

namespace volute {

/// Thin sheets that a segment crosses at `roots` (ascending) [m], as pieces of a medium: each takes
/// the share `opacity` of the light from behind and has the colour that `colourAt` says of a root's
/// place in the list.
void sheetPieces(const Segment& segment, std::span<const double> roots, double opacity,
                 const std::function<Rgb(std::size_t)>& colourAt, std::vector<Piece>& pieces);

/// The share of a sheet's colour that is seen of it, where the unit vector across it has the height
/// `up` (-1 to 1): the less it faces up, the darker.
double sheetShade(double up);

/// How a translucent surface looks.
struct IsoLook {
  double level = 0;          ///< of the field's values
  Rgb colour = Rgb::Ones();  ///< radiance of the surface where it faces up
  double opacity =
      0.45;  ///< share of the light from behind that each sheet takes, above 0, below 1
};

/// The surface on which a field has a level, as a medium: a sheet a millimetre thick wherever a ray
/// crosses it, so that it stands among smoke and fire in the right order. Crossings are roots of
/// the field's own cubics along the ray, so there is no mesh of triangles; of cells with one value
/// they are the faces between cells below and above. A sheet is the darker the steeper it stands.
/// Cheap to copy.
class FdsIso {
 public:
  /// `field` holds any quantity in place of an extinction.
  FdsIso(FdsField field, const IsoLook& look) : field_(std::move(field)), look_(look) {}

  Box3 bounds() const { return field_.bounds(); }

  /// A sheet has no thickness that a point would find.
  double extinction(const Vec3&) const { return 0; }

  Rgb emission(const Vec3&) const { return Rgb::Zero(); }

  void opticalDepth(std::span<const Segment> segments, std::span<double> depths) const;
  void pieces(std::span<const Segment> segments, std::span<std::vector<Piece>> pieces) const;
  void radiance(std::span<const Segment> segments, std::span<Radiance> out) const;

  /// Where a segment crosses the surface [m], ascending.
  std::vector<double> crossings(const Segment& segment) const;

 private:
  Rgb shaded(const Vec3& at) const;

  FdsField field_;
  IsoLook look_;
};

}  // namespace volute
