// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <mutex>

#include "volute/media/fog/fog_layer.hpp"
#include "volute/media/fog/lit_fog.hpp"
#include "volute/media/medium_kind.hpp"

namespace volute {

/// Fog at one instant.
class FogAt final : public MediumAt {
 public:
  /// @param lamps  that shine at it
  FogAt(FogLayer layer, double time, double factor, std::vector<Lamp> lamps, FogLight light);

  void addMedia(std::vector<AnyMedium>& media) const override;

  void addExtinction(std::vector<AnyMedium>& media) const override;

  /// By a polar table where the fog's description asks for one and it serves.
  Status addMediaFor(const Camera& camera, std::vector<AnyMedium>& media) const override;

  std::shared_ptr<const MediumAt> quick() const override;

  std::shared_ptr<const MediumAt> litBy(const MediaLight& light) const override;

  const FogMedium& fog() const { return fog_; }

  /// The same in the light of lamps, where any shine at it.
  const std::optional<LitMedium>& lit() const;

  double factor() const { return factor_; }

  const FogLayer& layer() const { return layer_; }

 private:
  FogLayer layer_;
  double time_;
  FogMedium fog_;
  double factor_;
  std::vector<Lamp> lamps_;
  FogLight light_;
  mutable std::once_flag made_;
  mutable std::optional<LitMedium> lit_;  ///< when somebody asks for it
};

/// A map of fog in a scene. Its map can be painted.
class FogSceneMedium final : public SceneMedium {
 public:
  explicit FogSceneMedium(FogLayer layer);

  Result<std::shared_ptr<const MediumAt>> at(const InstantRequest& request,
                                             Progress& progress) override;
  std::vector<std::string> files() const override;

  const FogDescription& description() const { return layer_.description(); }

  const FogLayer& layer() const { return layer_; }

  /// As it is shown, painted or not.
  FogLayer shown() const;

  /// Its map is one picture for all times.
  bool paintable() const;

  /// Replaces the map until it is saved [1/m]. kInvalidArgument for one of another size.
  /// @param unsaved  it is not what a file holds
  [[nodiscard]] Status paint(std::vector<double> coefficients, bool unsaved);

  bool unsaved() const { return unsaved_; }

  /// What was painted is in a file now.
  void savedAs(const std::string& map);

  /// What was painted on another one of the same size stays.
  void keepPainted(const FogSceneMedium& other);

 private:
  FogLayer layer_;
  std::optional<std::vector<double>> painted_;  ///< the map [1/m], instead of the file's,
  double paintedMost_ = 0;                      ///< while its densest was this [1/m]
  bool unsaved_ = false;                        ///< the painted map is in no file
};

const MediumKind& fogKind();

}  // namespace volute
