// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "volute/fog/fog_detail.hpp"
#include "volute/fog/fog_levels.hpp"
#include "volute/fog/fog_map.hpp"
#include "volute/fog/fog_profile.hpp"
#include "volute/medium/medium.hpp"

namespace volute {

struct FogOptions {
  int degree = 1;  ///< of the B-splines, 0..3
  int levels = 0;  ///< number of times the map is halved, 0..kMaxFogLevels
  FogDetail detail{};
  Restriction restriction = Restriction::kFullWeighting;
  Rgb color = Rgb::Ones();  ///< radiance of infinitely thick fog: albedo * ambient light
};

/// Fog from a painted map (Giroud and Biri 2010): extinction K(x, y, z) = rho(x, y) g(z), emission
/// color * K. Integrated exactly in every cell, for every degree and profile.
///
/// A Medium, FastMedium and LinearMedium. With FogOptions::detail other than the default, the
/// result for a segment depends on its origin (the eye); extinction() is then that of the finest
/// level. Cheap to copy: its data are shared and const.
class FogMedium {
 public:
  /// @param top  if given, there is no fog above these heights [m above the map's origin]: the
  /// map's
  ///   values are heights, its degree is 1, with any placement (its origin's z is ignored). The
  ///   finest level is integrated at every distance then.
  /// kInvalidArgument for options out of range.
  [[nodiscard]] static Result<FogMedium> make(const FogMap& map, const FogProfile& profile,
                                              const FogOptions& options = {},
                                              const std::optional<FogMap>& top = std::nullopt);

  Box3 bounds() const;

  double extinction(const Vec3& point) const;
  Rgb emission(const Vec3& point) const;

  /// Exact, in double.
  void opticalDepth(std::span<const Segment> segments, std::span<double> depths) const;

  /// One piece for each cell, profile zone and level that is not all zero.
  void pieces(std::span<const Segment> segments, std::span<std::vector<Piece>> pieces) const;

  /// The fast path, in float and SIMD: transmittances within 2e-6 of the reference. The result of a
  /// ray depends only on that ray. Skips empty parts of the map. With a `top` map it is the
  /// reference.
  void radiance(std::span<const Segment> segments, std::span<Radiance> out) const;

  /// With mu, FogDetail.
  bool dependsOnEnd() const { return levels_->count() > 1 && options_.detail.dependsOnEnd(); }

  /// The map, shape (rows, columns), row 0 at the smallest y.
  std::vector<double> coefficients() const;

  FogMedium withCoefficients(std::span<const double> coefficients) const;

  /// The same fog displaced [m], as by wind.
  FogMedium shifted(const Vec3& by) const;

  /// The same fog with details at all distances.
  FogMedium finest() const;

  /// The same map with another profile.
  FogMedium withProfile(const FogProfile& profile) const;

  /// The same with other levels of the same map size, as a sequence of maps has.
  FogMedium withLevels(std::shared_ptr<const FogLevels> levels) const;

  const FogOptions& options() const { return options_; }

  const FogProfile& profile() const { return profile_; }

  /// The pyramid and what the walks read, in cells of its own domain, whose corner is
  /// domainCorner().
  const FogLevels& levels() const { return *levels_; }

  /// [m]; the padding for levels lies between it and the map's origin.
  Vec3 domainCorner() const;

  /// [m], side of a finest cell.
  double cell() const { return cell_; }

  bool hasTop() const { return top_ != nullptr; }

  /// Where the fog ends upwards: heights [m] above the map's origin as a linear spline, 0 outside.
  std::optional<FogMap> top() const;

  /// A part of a segment that is in one zone of the profile and one level of detail.
  struct Stretch {
    int level = 0;
    const FogProfile::Zone* zone = nullptr;
    double begin = 0, end = 0;
  };

  /// Those that are not empty, front to back.
  void stretches(const Segment& segment, std::vector<Stretch>& out) const;

  /// The ray in cells of a level.
  PlaneRay planeRay(const Segment& segment, int level) const;

 private:
  struct Top;

  FogMedium() = default;
  template <class Visit>
  void cells(const Segment& segment, Visit&& visit) const;

  std::shared_ptr<const FogLevels> levels_;
  std::shared_ptr<const Top> top_;
  FogProfile profile_;
  FogOptions options_;
  Vec3 origin_ = Vec3::Zero();
  double cell_ = 1;
};

}  // namespace volute
