// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <span>
#include <string_view>

#include "volute/camera/camera.hpp"
#include "volute/image/colormap.hpp"
#include "volute/image/image.hpp"
#include "volute/media/medium_snapshot.hpp"

namespace volute {

/// What CFD programs draw instead of a medium (Staubli et al. 2005, figure 2): a plane with the
/// local values on it, or the surface on which they reach a bound.
struct Contour {
  enum class Kind { kSlice, kSurface };
  enum class Shows { kConcentration, kExtinction, kVisibility };

  Kind kind = Kind::kSlice;
  int axis = 2;                      ///< of a slice: across it, 0 x, 1 y, 2 z
  double place = 1.8;                ///< of a slice, along the axis [m]
  Shows shows = Shows::kVisibility;  ///< on a slice
  double visibility = 10;            ///< of a surface [m]: within it one sees less far
  double c = 3;                      ///< of the visibility S = C / K
  /// What the last colour of a slice stands for, and above it: [m], [1/m] or the unit of the
  /// concentration.
  double most = 30;
};

/// "z=1.8": axis and place of a slice.
[[nodiscard]] Result<Contour> parseSlice(std::string_view text);

/// The colours of a slice: viridis, whose last is clear air of a visibility; plasma for a
/// concentration, so that nobody takes the one for the other.
ColorMap colorMapOf(const Contour& slice);

/// The contour of all media that have one, in colorMapOf() (a slice) or shaded (a surface), in
/// buildings whose inner walls are grey. Linear RGB. kUnsupported where no medium has any.
[[nodiscard]] Result<Image> lookAtContour(
    const Camera& camera, std::span<const std::shared_ptr<const MediumSnapshot>> media,
    const Contour& contour);

/// The largest extinction [1/m] or concentration on a slice that shows it.
double largestOn(const Contour& slice,
                 std::span<const std::shared_ptr<const MediumSnapshot>> media);

}  // namespace volute
