// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
#include <vector>

#include "volute/fog/sun_shadow.hpp"
#include "volute/math/phase_function.hpp"
#include "volute/medium/sun.hpp"

namespace volute {

struct SunScattering {
  Rgb albedo = Rgb::Ones();  ///< share of the extinguished light that is scattered
  double asymmetry = 0;      ///< g of the phase function, -1 < g < 1; 0.6 to 0.9 for droplets
  /// The parts of a segment from which surfaces keep a sun (its number is the second argument)
  /// entirely, in order and apart from each other; replaces the third. Empty: none. The light is
  /// then integrated on both sides of each edge of a shadow, so that the edge itself costs no
  /// accuracy. emission() at a point knows nothing of them.
  std::function<void(const Segment&, std::size_t, std::vector<Interval>&)> shadows{};
  int samples = 1;  ///< of SunShadow
};

/// Fog that scatters the light of suns once, shadowed by itself and by the scene, beside the
/// constant light that FogOptions::color stands for:
///   L = integral of K (color + sum of albedo phase irradiance exp(-t_sun) V) exp(-t) ds.
///
/// A Medium and FastMedium. emission() at a point, which knows no direction, has the mean of the
/// phase function.
/// What reaches surfaces is irradiance * exp(-SunShadow::opticalDepth(point)).
class SunlitFog {
 public:
  /// kInvalidArgument for scattering out of range, and as SunShadow::make.
  [[nodiscard]] static Result<SunlitFog> make(const FogMedium& fog, std::span<const Sun> suns,
                                              const SunScattering& scattering = {});

  Box3 bounds() const { return fog_.bounds(); }

  double extinction(const Vec3& point) const { return fog_.extinction(point); }

  Rgb emission(const Vec3& point) const;

  void opticalDepth(std::span<const Segment> segments, std::span<double> depths) const {
    fog_.opticalDepth(segments, depths);
  }

  /// Those of the fog, cut until a parabola through the light at begin, middle and end of each is
  /// within 1e-4 of it (relative to the brightest) halfway between, or they are a 32nd of a cell
  /// long. For degree 3 a line, or with a linear profile a constant, stands for the parabola.
  void pieces(std::span<const Segment> segments, std::span<std::vector<Piece>> pieces) const;

  /// Transmittance and constant light as FogMedium::radiance. The light of suns by steps of at most
  /// a cell and an optical depth of 1/8, with the light at the middle of each: within some 1e-3 of
  /// the pieces' on maps that are smooth over a few cells.
  void radiance(std::span<const Segment> segments, std::span<Radiance> out) const;

  /// The same in light from which surfaces take nothing: quick, for previews.
  SunlitFog withoutShadows() const;

  const FogMedium& fog() const { return fog_; }

  const std::vector<Sun>& suns() const { return suns_; }

  const SunScattering& scattering() const { return scattering_; }

  /// One for each sun.
  const std::vector<SunShadow>& shadows() const { return shadows_; }

 private:
  explicit SunlitFog(FogMedium fog) : fog_(std::move(fog)) {}

  /// How much of a sun's light the fog lets through to a point, 0..1.
  double lit(const Vec3& point, std::size_t sun) const;

  /// The parts of a segment that each sun does not reach for the scene's surfaces.
  std::vector<std::vector<Interval>> shadowsOn(const Segment& segment) const;

  /// What a unit of extinction sends along `direction`.
  Rgb source(const Vec3& point, std::span<const double> phases) const;
  std::vector<double> phasesTowards(const Vec3& direction) const;
  void cut(const Segment& segment, const Piece& piece, std::span<const double> phases,
           std::vector<Piece>& out) const;
  /// The part of each sun's light, times its phase, that arrives at the begin of the segment.
  class Cells;
  std::vector<double> sunlight(const Segment& segment, Cells& cells) const;

  FogMedium fog_;
  std::vector<Sun> suns_;
  std::vector<SunShadow> shadows_;
  SunScattering scattering_;
};

}  // namespace volute
