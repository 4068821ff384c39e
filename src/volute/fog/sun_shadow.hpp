// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "volute/fog/fog_medium.hpp"

namespace volute {

class SunSums;

/// How much fog lies between any point and the sun, from two-dimensional maps that hold at every
/// height. With s the unit direction to the sun, s_z > 0, and p a place seen from above:
///   I_k(p) = integral over t > 0 of rho(p + s t) t^k,  S(p) = the same of rho exp(-s_z t / H);
/// constant zones need I_0, linear ones I_0 and I_1, and the depth above a point of an exponential
/// profile is g(z) S(p). Where the way through a zone is steep, so that it stays over a few cells,
/// differences of I_k would cancel: there rho itself is integrated by Gauss points.
///
/// The maps are sampled at the corners of cells (or more finely) and interpolated, so that they
/// blur by O(cell^2); at the samples they are those of the walk, on large maps those of SunSums.
/// Always of the finest level.
class SunShadow {
 public:
  /// @param towardsSun  its length does not matter
  /// @param samples  along the side of a cell, 1..8
  /// kInvalidArgument for a sun below or less than 0.06 degrees above the horizon; kUnsupported for
  /// fog with a top.
  [[nodiscard]] static Result<SunShadow> make(const FogMedium& fog, const Vec3& towardsSun,
                                              int samples = 1);

  /// The optical depth from a point, inside the fog or outside, to the sun.
  double opticalDepth(const Vec3& point) const;

  /// exp(-opticalDepth()) of many points, in float: within 1e-4.
  void shares(std::span<const Vec3> points, std::span<double> shares) const;

  /// Unit length.
  const Vec3& towardsSun() const { return sun_; }

  /// The maps for a shader, shape (rows, columns) of (rho, I_0, I_1, S), 0 where the profile needs
  /// none; what zoneDepth() and momentsAt() do with them is in gl/glsl/fog_sun.glsl too.
  struct Maps {
    int columns = 0, rows = 0;
    double x0 = 0, y0 = 0, step = 1;  ///< [m] place of the first, and from one to the next
    double decay = 0;                 ///< [1/m] of the exponential zone
    std::vector<float> texels;        ///< four each
  };

  Maps maps() const;

 private:
  /// Values at the corners of cells: bilinear between.
  struct Map {
    int columns = 0, rows = 0;
    std::vector<float> values;

    double at(double x, double y) const;
  };

  /// I_0 and I_1 at a place from above that may lie before the fog.
  struct Moments {
    double i0 = 0, i1 = 0;
  };

  explicit SunShadow(FogMedium fog) : fog_(std::move(fog)) {}

  Map sampled(const SunSums& sums) const;
  Map sampledDensity() const;
  /// Of a place from above [samples]: moves it to where the way to the sun enters the maps, and
  /// returns how long that way is, seen from above as sun_ is [m]; -1 where it never does.
  double entry(double& u, double& v) const;
  Moments momentsAt(double x, double y) const;
  double decayingAt(double x, double y) const;  ///< S
  double zoneDepth(const FogProfile::Zone& zone, const Vec3& point) const;

  FogMedium fog_;
  Vec3 sun_ = Vec3::UnitZ();
  double x0_ = 0, y0_ = 0, step_ = 1;  ///< [m], of the samples
  double decay_ = 0;                   ///< [1/m], of the exponential zone
  std::shared_ptr<const Map> rho_, i0_, i1_, s_;
};

}  // namespace volute
