// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/base/result.hpp"
#include "volute/image/image.hpp"
#include "volute/math/vec.hpp"
#include "volute/wavelet/spline_pyramid.hpp"

namespace volute {

/// Placement and scale of a fog map.
struct FogPlacement {
  Vec3 origin = Vec3::Zero();  ///< [m] corner x = y = 0 of the map; heights are relative to its z
  double cell = 1;             ///< [m], side of a finest cell
  double sigmaMax = 0.05;      ///< [1/m], the extinction of a pixel of value 1
};

/// How a picture with three channels is converted.
enum class FogColour {
  kRefuse,
  kLuma,  ///< Rec. 709 luma of the stored pixel values, without decoding
};

/// A painted map of fog: the horizontal part of K(x, y, z) = rho(x, y) g(z).
///
/// rho(x, y) = sum of c(i, j) N(X - i) N(Y - j), X = (x - origin.x) / cell and Y likewise, with
/// B-splines N of a degree d that the medium chooses. Coefficient (i, j) is column i, row j counted
/// from the bottom row of the picture, and peaks at X = i + (d + 1) / 2. n coefficients cover n + d
/// cells. For d >= 2 coefficients are a control net: the density is smoother than the map and lies
/// between the smallest and the largest of the (d + 1)^2 coefficients around.
struct FogMap {
  SplineGrid coefficients;     ///< [1/m], finite and >= 0; at(i, j), row 0 at the smallest y
  Vec3 origin = Vec3::Zero();  ///< [m]
  double cell = 1;             ///< [m]

  /// pixel * sigmaMax, linear. The picture's first row becomes the row of the largest y.
  ///
  /// kInvalidArgument for an invalid placement, kInvalidData for a picture without
  /// pixels, one of three channels unless `colour` allows it, and pixels that are negative or not
  /// finite.
  [[nodiscard]] static Result<FogMap> fromImage(const Image& pixels, const FogPlacement& placement,
                                                FogColour colour = FogColour::kRefuse);

  /// A map from spline coefficients [1/m] instead of pixels.
  [[nodiscard]] static Result<FogMap> fromCoefficients(SplineGrid coefficients,
                                                       const FogPlacement& placement);
};

}  // namespace volute
