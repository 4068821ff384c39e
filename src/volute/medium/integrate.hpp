// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "volute/medium/medium.hpp"

// The reference integrator: scalar, double, and obviously correct. All faster implementations are
// tested against it.

namespace volute {

/// The integral of curve(u) * exp(-decay u) over 0 <= u <= length, in closed form and without
/// cancellation for any decay. `length` may be infinite: then decay > 0, or a curve that is not
/// zero gives infinity.
double decayingIntegral(const Polynomial& curve, double decay, double length);

/// The integral of the extinction over the piece, dimensionless.
double pieceOpticalDepth(const Piece& piece);

/// The integral of the emission over the piece as if nothing were absorbed, linear RGB radiance.
Rgb pieceEmission(const Piece& piece);

/// The part of `piece` between the ray parameters `begin` and `end` (piece.begin <= begin < end <=
/// piece.end).
Piece clipped(const Piece& piece, double begin, double end);

/// Emission and absorption from front to back through the pieces of one medium (ordered, without
/// overlap). Closed form where the extinction is zero or the emission is a multiple of it (constant
/// media, fog of one colour); else Gauss quadrature to 1e-10 of the piece's brightest channel,
/// whose error estimate, summed over the pieces, goes to `errorBound` [radiance].
Radiance composite(std::span<const Piece> pieces, double* errorBound = nullptr);

/// The same for several media on one ray, one list of pieces each. Where they overlap, extinctions
/// and emissions add.
Radiance compositeMedia(std::span<const std::vector<Piece>> perMedium,
                        double* errorBound = nullptr);

/// Segments of whose pieces a loop takes care at once: few enough that they stay in the cache, and
/// in memory that the next ones use again.
inline constexpr std::size_t kSegmentsAtOnce = 32;

/// Calls `each(i, pieces)` for every segments[i].
template <Medium M, class Each>
void forPieces(const M& medium, std::span<const Segment> segments, Each&& each) {
  std::vector<std::vector<Piece>> pieces(std::min(kSegmentsAtOnce, segments.size()));
  for (std::size_t first = 0; first < segments.size(); first += kSegmentsAtOnce) {
    const std::size_t count = std::min(kSegmentsAtOnce, segments.size() - first);
    medium.pieces(segments.subspan(first, count), std::span(pieces).first(count));
    for (std::size_t i = 0; i < count; ++i) each(first + i, pieces[i]);
  }
}

/// Used by AnyMedium for a medium without its own radiance().
template <Medium M>
void radianceByPieces(const M& medium, std::span<const Segment> segments, std::span<Radiance> out) {
  forPieces(medium, segments,
            [&](std::size_t i, const std::vector<Piece>& pieces) { out[i] = composite(pieces); });
}

/// The integral of a function of the point over the part of `segment` inside `bounds`, by adaptive
/// Simpson to about `tolerance` (absolute) after a first cut into `cuts` parts, which keeps
/// features of that size from being missed.
double integralOfPoints(const std::function<double(const Vec3&)>& value, const Box3& bounds,
                        const Segment& segment, double tolerance, int cuts = 16);

/// The optical depth computed only from the extinction at points: the conformance suite compares
/// the closed forms with it.
template <Medium M>
double opticalDepthByQuadrature(const M& medium, const Segment& segment, double tolerance) {
  return integralOfPoints([&](const Vec3& point) { return double(medium.extinction(point)); },
                          medium.bounds(), segment, tolerance);
}

}  // namespace volute
