// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <concepts>
#include <span>
#include <vector>

#include "volute/math/box.hpp"
#include "volute/math/polynomial.hpp"
#include "volute/math/vec.hpp"

// A medium is a list of coefficients over basis functions, and Volute does one thing with it:
// integrate it along a ray segment. A Medium object is the medium at one time; a medium that varies
// in time makes one object for each time.

namespace volute {

/// The points origin + s * direction, begin <= s <= end. `direction` has unit length, so s is in
/// metres; begin may be -infinity and end +infinity. Empty when end <= begin.
struct Segment {
  Vec3 origin = Vec3::Zero();
  Vec3 direction = Vec3::UnitX();
  double begin = 0;
  double end = 0;

  Vec3 at(double s) const { return origin + s * direction; }

  bool empty() const { return !(begin < end); }
};

/// A stretch of a segment on which the medium has a closed form. With u = s - begin:
///   extinction(u) = extinction polynomial * exp(-decay u)   [1/m]
///   emission(u)   = emission polynomials  * exp(-decay u)   [radiance/m], linear RGB
struct Piece {
  double begin = 0;  ///< [m], parameter of the segment; finite
  double end = 0;    ///< infinite only when decay > 0 or all polynomials are constant
  Polynomial extinction;
  Polynomial emission[3];
  double decay = 0;  ///< [1/m]; 0 except for exponential height profiles; decay * length > -700
};

/// The result of a segment: the light emitted along it that reaches its begin, and the transmitted
/// share of the light from behind.
struct Radiance {
  Rgb emitted = Rgb::Zero();
  double transmittance = 1;
};

/// A medium over any basis. All calls are const and thread-safe, and take segments in batches: the
/// cost of the indirection is paid per batch, never per sample.
template <class M>
concept Medium = requires(const M& medium, const Vec3& point, std::span<const Segment> segments,
                          std::span<double> depths, std::span<std::vector<Piece>> pieces) {
  /// Outside, extinction and emission are zero. Never empty; may be infinite.
  { medium.bounds() } -> std::convertible_to<Box3>;
  /// [1/m] at a point; for probes and tests only.
  { medium.extinction(point) } -> std::convertible_to<double>;
  /// [radiance/m] at a point; for probes and tests only.
  { medium.emission(point) } -> std::convertible_to<Rgb>;
  /// The integral of the extinction over each segment, dimensionless, exact for the basis.
  medium.opticalDepth(segments, depths);
  /// Replaces pieces[i] by the pieces of segments[i], front to back, without overlap; gaps are
  /// empty space.
  medium.pieces(segments, pieces);
};

/// A medium that can integrate emission and absorption itself, faster than through its pieces.
template <class M>
concept FastMedium =
    Medium<M> && requires(const M& medium, std::span<const Segment> segments,
                          std::span<Radiance> out) { medium.radiance(segments, out); };

/// A medium that may say that its values at a point depend on where a segment ends. A part of a
/// segment of such a medium is another segment: who cuts it gets other values.
template <class M>
concept MindsTheEnd = Medium<M> && requires(const M& medium) {
  { medium.dependsOnEnd() } -> std::convertible_to<bool>;
};

/// A medium whose optical depth is linear in a list of coefficients c: depth = P c. Tomography has
/// P and its adjoint P' for voxels in a class of its own (tomography/projector.hpp), which is made
/// for many rays.
template <class M>
concept LinearMedium =
    Medium<M> && requires(const M& medium, std::span<const double> coefficients) {
      { medium.coefficients() } -> std::convertible_to<std::vector<double>>;
      /// The same basis with other coefficients, as many.
      { medium.withCoefficients(coefficients) } -> std::convertible_to<M>;
    };

}  // namespace volute
