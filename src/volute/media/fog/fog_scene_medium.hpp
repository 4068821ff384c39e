// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <mutex>

#include "volute/fog/fog_sequence.hpp"
#include "volute/fog/polar_table.hpp"
#include "volute/geometry/triangle_scene.hpp"
#include "volute/media/field_probe.hpp"
#include "volute/media/fog/fog_file.hpp"
#include "volute/media/fog/lit_fog.hpp"
#include "volute/media/scene_medium.hpp"

namespace volute {

class MediumKind;
class FogSceneMedium;
struct Reading;

/// Whether any of its surfaces takes sunlight from the fog.
bool shadowsFog(const TriangleScene& geometry, std::span<const Lamp> lamps, const FogMedium& fog);

/// Fog at one time.
class FogSnapshot final : public MediumSnapshot {
 public:
  /// @param lamps  that shine at it
  FogSnapshot(std::shared_ptr<const FogSceneMedium> map, double time, double factor,
              std::vector<Lamp> lamps, FogLight light);

  void addMedia(std::vector<AnyMedium>& media) const override;

  void addExtinction(std::vector<AnyMedium>& media) const override;

  /// By a polar table where the fog's description asks for one and it serves.
  Status addMediaFor(const Camera& camera, std::vector<AnyMedium>& media) const override;

  std::shared_ptr<const MediumSnapshot> quick() const override;

  std::shared_ptr<const MediumSnapshot> litBy(const MediaLight& light) const override;

  const FogMedium& fog() const { return fog_; }

  /// The same in the light of lamps, where any shine at it.
  const std::optional<LitMedium>& lit() const;

  double factor() const { return factor_; }

  /// The medium in time that this is a snapshot of.
  const std::shared_ptr<const FogSceneMedium>& map() const { return map_; }

 private:
  std::shared_ptr<const FogSceneMedium> map_;
  double time_;
  FogMedium fog_;
  double factor_;
  std::vector<Lamp> lamps_;
  FogLight light_;
  mutable std::once_flag made_;
  mutable std::optional<LitMedium> lit_;  ///< when somebody asks for it
};

/// A map of fog in a scene, in memory. It can be painted.
class FogSceneMedium final : public SceneMedium, public ProbedMedium {
 public:
  /// Reads the maps. Errors begin with FogDescription::where or with the name of a map.
  [[nodiscard]] static Result<std::shared_ptr<FogSceneMedium>> open(
      const FogDescription& description, std::vector<Lamp> lamps, Reading& reading);

  /// Whether with() serves: both differ at most in profile, wind, clock, scattering, path and, for
  /// fog without a top, in the origin.
  static bool readsTheSame(const FogDescription& a, const FogDescription& b);

  /// This fog with another description, for which readsTheSame() holds apart from the file its map
  /// was saved to since, and other lamps. Reads no map again; not painted yet.
  std::shared_ptr<FogSceneMedium> with(const FogDescription& description,
                                       std::vector<Lamp> lamps) const;

  Result<std::shared_ptr<const MediumSnapshot>> at(const SnapshotRequest& request,
                                                   Progress& progress) override;
  std::vector<std::string> files() const override;
  std::unique_ptr<FieldProbe> fieldProbe() const override;

  const FogDescription& description() const { return description_; }

  /// At a time of the scene [s]: the maps at its clock's time, blown by the wind. Not painted.
  FogMedium fogAt(double time) const;

  /// The same as if there were clear air beyond its border: its coefficients are the map's.
  FogMedium mapAt(double time) const;

  /// Options of the polar table for a camera; nothing if cells are traversed instead: on request,
  /// or because tables support only degrees 1 to 3 without suns.
  std::optional<PolarOptions> polarFor(const Camera& camera, const FogMedium& fog) const;

  /// What --frames calls a map, and when it is shown as it is, in the scene's time [s].
  int numberOf(int position) const { return position; }

  double timeOf(int position) const;

  /// As it is shown: itself, or one whose map is what was painted.
  std::shared_ptr<const FogSceneMedium> shown() const;

  /// Its map is one picture for all times.
  bool paintable() const;

  /// Replaces the map until it is saved [1/m]. kInvalidArgument for one of another size.
  /// @param unsaved  it is not what a file holds
  [[nodiscard]] Status paint(std::vector<double> coefficients, bool unsaved);

  bool unsaved() const { return unsaved_; }

  /// What was painted is in a file now.
  void savedAs(const std::string& map);

  /// Takes over the map painted on another fog of the same size.
  void keepPainted(const FogSceneMedium& other);

 private:
  FogMedium stored(double time) const;
  Result<FogMedium> bordered(const FogMedium& map, const Vec3& blown) const;
  std::size_t values() const;
  void describe();

  FogDescription description_;
  Vec3 readAt_ = Vec3::Zero();  ///< the origin of the maps as they are held [m]
  std::vector<Lamp> lamps_;
  std::vector<double> times_;
  std::shared_ptr<const FogSequence> sequence_;
  std::shared_ptr<const FogMedium> still_;      ///< instead, where there is a top, or it is painted
  std::optional<std::vector<double>> painted_;  ///< the map [1/m], instead of the file's,
  double paintedMost_ = 0;                      ///< while its densest was this [1/m]
  bool unsaved_ = false;                        ///< the painted map is in no file
};

const MediumKind& fogKind();

}  // namespace volute
