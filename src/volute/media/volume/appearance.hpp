// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>
#include <string>

#include "volute/grid/volume_info.hpp"
#include "volute/media/clock.hpp"
#include "volute/media/placement.hpp"
#include "volute/media/volume/transfer.hpp"

namespace volute {

/// Black bodies that glow in a volume: where a grid of flames says so, and as hot as a grid of
/// temperatures says, or as the flames are strong.
struct Flames {
  std::string field;        ///< the grid of flames; empty: all that is hot glows
  double scale = 1;         ///< multiplies the grid of flames first
  double brightness = 1;    ///< luminance per metre of a flame of 1, or of the hottest
  double coolest = 1100;    ///< [K] of a flame of 0
  double hottest = 2000;    ///< [K] of a flame of 1
  std::string temperature;  ///< the grid of temperatures; empty: coolest to hottest
  double kelvin = 1;        ///< of one unit of it
  double zero = 0;          ///< [K] that its 0 stands for

  bool operator==(const Flames&) const = default;
};

/// What is shown between two stored frames.
enum class Interpolation {
  kNone,      ///< the one before
  kAuto,      ///< kVelocity where there is a grid of velocities, else kLinear
  kLinear,    ///< from one to the other, in place
  kVelocity,  ///< both, moved along the velocities to where they are then
};

/// What a grid of velocities is in. Its vectors are those of the file's world, which turn with its
/// placement as OpenVDB's type of them says (VectorKind); voxels, and vectors that OpenVDB calls
/// local, lie along the grid's axes.
enum class VelocityUnit { kMetresPerSecond, kVoxelsPerFrame, kMetresPerFrame };
constexpr std::string_view kVelocityUnits[] = {"m/s", "voxels/frame", "m/frame"};

/// Whether what a volume emits is light for surfaces and other media.
enum class LightsScene {
  kAuto,  ///< where flames burn in it
  kAlways,
  kNever,
};

/// How a volume looks, and where and when.
struct Appearance {
  double emission = 1;       ///< radiance per metre per unit
  double extinction = 0;     ///< 1/m per unit
  Rgb albedo = Rgb::Zero();  ///< share of the extinguished light that is scattered
  double asymmetry = 0;      ///< g of Henyey and Greenstein, -1 < g < 1
  std::optional<Flames> flames{};
  std::optional<Transfer> transfer{};  ///< instead of all of the above
  std::string
      colors{};  ///< the grid (three channels, or three grids _r, _g, _b) that colours albedo
  LightsScene lightsScene = LightsScene::kAuto;
  std::optional<Basis> basis;  ///< instead of the file's
  bool basisByView = false;    ///< nobody said it: what is seen closely is drawn over the cubic one
  bool surface = false;  ///< of a level set: it is opaque where the distance is 0, and nothing else
  bool refines = false;  ///< a cubic basis is drawn by refinedSpline(): not for measurements
  Placement placement;
  Clock clock;
  Interpolation interpolation = Interpolation::kNone;
  double velocityScale = 1;  ///< multiplies the grid of velocities
  VelocityUnit velocityUnit = VelocityUnit::kMetresPerSecond;

  bool scatters() const { return extinction > 0 && albedo.maxCoeff() > 0; }

  bool lights() const {
    return lightsScene == LightsScene::kAuto ? flames.has_value()
                                             : lightsScene == LightsScene::kAlways;
  }

  /// Whether it is more than one grid of emission and extinction.
  bool shaded() const { return scatters() || flames.has_value() || transfer.has_value(); }
};

}  // namespace volute
