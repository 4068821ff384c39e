// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "volute/fog/fog_medium.hpp"

namespace volute {

/// Rays from one eye, as the rows of a picture have them; all spans are as long.
struct EyeRays {
  Vec3 eye = Vec3::Zero();
  std::span<const float> x, y, z;   ///< unit directions
  std::span<const float> distance;  ///< [m], to the nearest surface; may be infinite
};

/// A range of azimuths: directions whose horizontal part is (cos yaw, sin yaw) plus q times the
/// perpendicular to its left, |q| <= tangent.
struct PolarSector {
  double yaw = 0;      ///< [rad], from +x to +y
  double tangent = 1;  ///< of half the angle

  /// What the rays span, if they all lead to one side; nullopt else, as when they contain the
  /// zenith.
  static std::optional<PolarSector> of(const EyeRays& rays);
};

struct PolarOptions {
  int azimuths = 0;  ///< in each sector; 0: by the map's size
  int radii = 0;     ///< 0: by the map's size
  /// What is looked at; nullopt: all around, in four sectors.
  std::optional<PolarSector> sector = std::nullopt;
};

/// The largest error of a transmittance that is looked up.
inline constexpr double kPolarError = 1e-4;

/// Where the entries of a table are.
struct PolarLayout {
  double yaw = 0, tangent = 1;  ///< of the sector, or of the first of four
  int sectors = 1;              ///< 4: all around
  int azimuths = 0, radii = 0;  ///< azimuths in each sector
  double from = 0, step = 1;    ///< radii [m]

  /// As PolarTable::make. A sector is no wider than the map is, seen from an eye beside it.
  [[nodiscard]] static Result<PolarLayout> of(const FogMedium& fog, const Vec3& eye,
                                              const PolarOptions& options);
};

/// The largest bends of a map along x and along y, |c(i - 1) - 2 c(i) + c(i + 1)| [1/m], by which a
/// table's error between azimuths is bounded.
std::array<double, 2> largestBends(const SplineGrid& map);

/// All rays from one eye with one azimuth see the same density, one above the other. So its
/// integrals over the horizontal distance, M_k(azimuth, r) = integral of rho r'^k dr' up to r, k =
/// 0 and 1, serve every pixel with two look-ups for each zone of the profile:
///   slab or constant g:    t = (M_0(b) - M_0(a)) / cos E
///   g = g_0 + m z, z = r tan E:  t = (g_0 (M_0(b) - M_0(a)) + m tan E (M_1(b) - M_1(a))) / cos E
/// with E the elevation. Cubic between radii, linear between azimuths; the sampled azimuths and
/// radii are exact. |dT| is O(azimuth step^2). The table estimates the error of each look-up by
/// differences of its entries, and by what floats hold at their distance; rays for which it is
/// above kPolarError are walked. They are few with the default sizes on painted maps, and all of
/// them far away or on noise.
///
/// For one eye only: another eye needs another table.
class PolarTable {
 public:
  /// kUnsupported for fog with a top, with an exponential profile, which has no separable table, or
  /// with dropped details: those are walked (FogMedium::radiance).
  [[nodiscard]] static Result<PolarTable> make(const FogMedium& fog, const Vec3& eye,
                                               const PolarOptions& options = {});

  /// exp(-optical depth) of rays from the table's eye; -1 for rays that have to be walked: which
  /// are steep (cos E < 0.15), end within a cell of the eye, leave the sector, or would be further
  /// off than kPolarError.
  void lookUp(const EyeRays& rays, std::span<float> out) const;

  /// The same with the others walked.
  void transmittance(const EyeRays& rays, std::span<float> out) const;

  int azimuths() const { return azimuths_; }

  int radii() const { return radii_; }

  /// [m]
  double firstRadius() const { return from_; }

  /// [m], from one radius to the next.
  double radiusStep() const { return step_; }

 private:
  explicit PolarTable(FogMedium fog) : fog_(std::move(fog)) {}

  friend struct PolarLook;

  FogMedium fog_;
  Vec3 eye_ = Vec3::Zero();
  double yaw_ = 0, tangent_ = 1;
  int sectors_ = 1, azimuths_ = 0, radii_ = 0;
  double from_ = 0, step_ = 1;  ///< radii [m]
  int stride_ = 2;  ///< floats in an entry: M_0, rho, and with linear profiles M_1, rho r
  /// shape (sectors, azimuths, radii, stride)
  std::shared_ptr<const std::vector<float>> entries_;
  int blocks_ = 1;  ///< of radii
  /// Of M_0, and of M_1 with linear profiles: of an azimuth and the next, in a block of radii;
  /// shape (sectors, azimuths, blocks, stride / 2)
  std::shared_ptr<const std::vector<float>> errors_;
};

}  // namespace volute
