// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "volute/camera/camera.hpp"
#include "volute/fog/fog_sequence.hpp"
#include "volute/fog/polar_table.hpp"
#include "volute/geometry/triangle_scene.hpp"
#include "volute/media/fog/fog_file.hpp"
#include "volute/media/reading.hpp"
#include "volute/medium/any_medium.hpp"

namespace volute {

/// Whether any of its surfaces takes sunlight from the fog.
bool shadowsFog(const TriangleScene& geometry, std::span<const Lamp> lamps, const FogMedium& fog);

/// Fog whose maps are in memory: gives the medium at any time.
class FogLayer {
 public:
  /// Reads the maps. Errors begin with FogDescription::where or with the name of a map.
  [[nodiscard]] static Result<FogLayer> open(const FogDescription& description,
                                             std::vector<Lamp> lamps, Reading& reading);

  /// Whether with() serves: both differ at most in profile, wind, clock, scattering, path and, for
  /// fog without a top, in the origin.
  static bool readsTheSame(const FogDescription& a, const FogDescription& b);

  /// This fog under a description, which readsTheSame() as its own, but for what its map was saved
  /// as since, and other lamps: no map is read again.
  FogLayer with(const FogDescription& description, std::vector<Lamp> lamps) const;

  const FogDescription& description() const { return description_; }

  /// At a time of the scene [s]: the maps at its clock's time, blown by the wind.
  FogMedium fogAt(double time) const;

  /// The same as if there were clear air beyond its border: its coefficients are the map's.
  FogMedium mapAt(double time) const;

  /// How a polar table of a fog of it is to be made for a camera; nothing where it is to be walked:
  /// exactly, or since a table serves only degrees from 1 to 3 without suns.
  std::optional<PolarOptions> polarFor(const Camera& camera, const FogMedium& fog) const;

  /// That light it.
  std::span<const Lamp> lamps() const { return lamps_; }

  /// The same with another map of the same size [1/m], at all times.
  FogLayer withMap(std::span<const double> coefficients) const;

  /// Its only map is in this file from now on.
  void setMapName(const std::string& file) { description_.maps = {file}; }

  /// How many maps there are.
  int frames() const { return static_cast<int>(times_.size()); }

  /// What --frames calls a map.
  int numberOf(int position) const { return position; }

  /// When a map is shown as it is, in the scene's time [s].
  double timeOf(int position) const;

 private:
  FogLayer() = default;

  FogMedium stored(double time) const;
  Result<FogMedium> bordered(const FogMedium& map, const Vec3& blown) const;

  FogDescription description_;
  Vec3 readAt_ = Vec3::Zero();  ///< the origin of the maps as they are held [m]
  std::vector<Lamp> lamps_;
  std::vector<double> times_;
  std::shared_ptr<const FogSequence> sequence_;
  std::shared_ptr<const FogMedium> still_;  ///< instead, where there is a top
};

}  // namespace volute
