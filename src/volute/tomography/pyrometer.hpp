// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <span>
#include <vector>

#include "volute/capture/spectrum.hpp"
#include "volute/tomography/reconstruct.hpp"

namespace volute {

/// Soot that shines.
struct Soot {
  double temperature = 0;  ///< [K]; 0: not determined
  double extinction = 0;   ///< [1/m] at CaptureSpectrum::kReference
};

/// Temperature and extinction of soot from what it sends in three channels: Planck's law and an
/// extinction that goes with a power of the wavelength (Rayleigh; three-colour pyrometry).
class Pyrometer {
 public:
  explicit Pyrometer(const CaptureSpectrum& spectrum);

  /// What is known besides a voxel's own light.
  struct Around {
    double noise = 0;        ///< of a channel's emission
    double temperature = 0;  ///< [K] that is usual: colours that tell less give it; 0: none
    double spread = 0.15;    ///< of it, as a share
  };

  /// @param emission  of a volume where nothing takes light on its way [radiance/m]
  /// @return temperature 0 where two channels do not shine, or no temperature from 700 to 4000 K
  ///   explains their ratio best.
  Soot sootOf(const Rgb& emission, const Around& around) const;

  /// The same of what is known by itself.
  Soot sootOf(const Rgb& emission) const { return sootOf(emission, {}); }

  /// What soot with an extinction of 1/m sends.
  Rgb sootColours(double temperature) const { return at(temperature).emission.exp(); }

  /// The relative standard deviations of temperature and extinction.
  /// @param relative  those of the channels
  /// @param correlation  of the channels' errors, 0..1
  Soot uncertainty(const Rgb& emission, const Soot& soot, const Rgb& relative,
                   double correlation) const;

  /// The absorption coefficient of each channel [1/m].
  Rgb extinctionOf(const Soot& soot) const;

 private:
  struct Row {
    double temperature = 0;
    Rgb emission;    ///< logarithm, of soot with an extinction of 1/m
    Rgb extinction;  ///< of a channel, of the same
  };

  Row at(double temperature) const;

  std::vector<Row> rows_;
};

/// The means of each channel of three over the 27 voxels around each.
std::vector<float> meansAround(const std::array<int, 3>& resolution,
                               std::span<const float> emission);

/// How far a voxel's temperature is from that around it, as a share.
inline constexpr double kNearSoot = 0.05;

/// The soot of each voxel of a volume. Colours are its own and meansAround(); where
/// they are faint, the temperature tends to that of the whole light. Not determined where the
/// brightest channel is below 2 % of the brightest voxel.
std::vector<Soot> sootOf(const Pyrometer& pyrometer, const std::array<int, 3>& resolution,
                         std::span<const float> emission);

/// What is sent, and its standard deviations.
struct KnownLight {
  Rgb light, deviation;
};

/// The standard deviations of a voxel's soot [K, 1/m]; 0 where it is not determined.
/// @param own, around  the voxel's, and meansAround() of those
/// @param correlation  of the channels' errors, 0..1
Soot deviationOf(const Pyrometer& pyrometer, const Soot& soot, const KnownLight& own,
                 const KnownLight& around, double correlation);

/// Factors on a view's pixels that undo what the soot takes of its own light on the way to the
/// camera, 1 to 5, (height, width, 3).
std::vector<float> sootAttenuation(const Pyrometer& pyrometer, std::span<const Soot> soot,
                                   const Camera& camera, const VolumeGeometry& geometry,
                                   std::span<const float> emission);

/// The emission of a flame that may be thick: a linear reconstruction, the extinction that its
/// colours tell, pixels as they would be without that, and again until they change no more, at most
/// four times.
/// @param views  become those without attenuation.
/// Errors: those of reconstruct().
[[nodiscard]] Result<Reconstruction> reconstructFlame(
    std::span<TomographyView> views, std::span<const std::size_t> fitted,
    const VolumeGeometry& geometry, const TomographyOptions& options, const Pyrometer& pyrometer,
    std::span<const float> warmStart, Progress& progress);

}  // namespace volute
