// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <vector>

#include "volute/medium/conformance_checks.hpp"

// Three small media as different as media get: what the conformance suite is proved with, and
// worked examples for whoever writes the next one. Tests of other modules may use them.

namespace volute::conformance {

/// Trilinear between the nodes of a grid, zero outside the box of its nodes (so it jumps there).
/// Along a ray a cubic in each cell. The coefficients are the extinction at the nodes; the emission
/// is trilinear too, with values of its own.
class TrilinearVoxels {
 public:
  using Index = std::array<int, 3>;

  /// Values at the nodes are drawn from [0, 1) by a seed. `nodes` is at least 2 on each axis.
  TrilinearVoxels(const Index& nodes, const Vec3& origin, const Vec3& cell, std::uint32_t seed);

  Box3 bounds() const;
  double extinction(const Vec3& point) const;
  Rgb emission(const Vec3& point) const;
  void opticalDepth(std::span<const Segment> segments, std::span<double> depths) const;
  void pieces(std::span<const Segment> segments, std::span<std::vector<Piece>> pieces) const;

  std::vector<double> coefficients() const { return extinction_; }

  TrilinearVoxels withCoefficients(std::span<const double> coefficients) const;
  /// Coordinates of the nodes along each axis: the planes on which the medium is not smooth.
  std::array<std::vector<double>, 3> planes() const;

 private:
  /// A stretch of a segment inside one cell, and the eight basis functions along it, cubics in s -
  /// begin.
  struct Crossing {
    double begin, end;
    std::array<std::size_t, 8> nodes;
    std::array<Cubic, 8> basis;
  };

  std::vector<Crossing> crossings(const Segment& segment) const;
  Crossing crossing(const Segment& segment, double begin, double end) const;
  Index cellOf(const Vec3& point) const;
  double interpolate(const std::vector<double>& values, const Vec3& point) const;

  Index nodes_;
  Vec3 origin_, cell_;
  std::vector<double> extinction_;               ///< [1/m], x fastest
  std::array<std::vector<double>, 3> emission_;  ///< [radiance/m]
};

/// Fog that is even up to `bottom` and thins out as exp(-height / scale height) above, without an
/// upper end: bounds and pieces may be infinite. One coefficient, the extinction on the ground. The
/// glow grows along x, so that emission is no multiple of extinction.
class Atmosphere {
 public:
  explicit Atmosphere(double extinctionAtGround) : ground_(extinctionAtGround) {}

  Box3 bounds() const;

  double extinction(const Vec3& point) const { return ground_ * profile(point); }

  Rgb emission(const Vec3& point) const;
  void opticalDepth(std::span<const Segment> segments, std::span<double> depths) const;
  void pieces(std::span<const Segment> segments, std::span<std::vector<Piece>> pieces) const;

  std::vector<double> coefficients() const { return {ground_}; }

  Atmosphere withCoefficients(std::span<const double> coefficients) const {
    return Atmosphere(coefficients[0]);
  }

  static constexpr double kBottom = 2;       ///< [m]
  static constexpr double kScaleHeight = 3;  ///< [m]

 private:
  double profile(const Vec3& point) const;

  double ground_;
};

/// Two boxes apart from each other: a ray may enter, leave and enter again. The first is even; in
/// the second the extinction runs linearly along x from the second to the third coefficient. Has a
/// fast path of its own.
class TwoBoxes {
 public:
  explicit TwoBoxes(const std::array<double, 3>& coefficients) : c_(coefficients) {}

  Box3 bounds() const;
  double extinction(const Vec3& point) const;
  Rgb emission(const Vec3& point) const;
  void opticalDepth(std::span<const Segment> segments, std::span<double> depths) const;
  void pieces(std::span<const Segment> segments, std::span<std::vector<Piece>> pieces) const;
  void radiance(std::span<const Segment> segments, std::span<Radiance> out) const;

  std::vector<double> coefficients() const { return {c_.begin(), c_.end()}; }

  TwoBoxes withCoefficients(std::span<const double> c) const {
    return TwoBoxes({c[0], c[1], c[2]});
  }

  static const Box3 kFirst, kSecond;

 private:
  std::array<double, 3> c_;  ///< [1/m]
};

MediumUnderTest trilinearVoxelsUnderTest();
MediumUnderTest atmosphereUnderTest();
MediumUnderTest twoBoxesUnderTest();

// What the suite must know of each.
Traits traitsOf(const TrilinearVoxels& voxels);
Traits traitsOf(const Atmosphere& atmosphere);
Traits traitsOf(const TwoBoxes& boxes);

}  // namespace volute::conformance
