// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/media/medium_kind.hpp"
#include "volute/media/smoke/smoke_layer.hpp"

namespace volute {

/// Smoke on tetrahedra at one instant.
class SmokeAt final : public MediumAt {
 public:
  SmokeAt(SmokeState state, double factor, std::shared_ptr<const SmokeLighting> lighting,
          std::optional<Rgb> walls, Team* holders = nullptr)
      : state_(std::move(state)),
        factor_(factor),
        lighting_(std::move(lighting)),
        walls_(std::move(walls)),
        holders_(holders) {}

  void addMedia(std::vector<AnyMedium>& media) const override;
  std::shared_ptr<MediumPicture> picture(std::shared_ptr<MediumPicture> earlier) const override;

  bool drawsItself() const override { return true; }

  /// Where this process holds all of it; its walls see no more than before.
  std::shared_ptr<const MediumAt> litBy(const MediaLight& light) const override;

  std::uint64_t memoryBytes() const override {
    return 3 * state_.extinction.size() * sizeof(float);
  }

  bool hasWalls() const override { return walls_.has_value(); }

  std::optional<WallHit> wallOn(const Segment& ray) const override;
  Result<SurfaceView> lookAtWalls(const Camera& camera, const TriangleScene& others,
                                  std::span<const std::uint8_t> only) const override;
  bool addContour(const Contour& contour, const Camera& camera,
                  ContourPieces& pieces) const override;

  /// As the files have it, whatever the law.
  const SmokeState& state() const { return state_; }

  double factor() const { return factor_; }

  /// Whose ranks hold a share each; null: this process holds all.
  Team* holders() const { return holders_; }

  /// [1/m], times the factor, one for each vertex.
  std::vector<float> extinction() const;

  const SceneLights& lights() const { return lighting_->lights; }

  /// What the mesh's boundary reflects; nothing: it is not shown.
  const std::optional<Rgb>& walls() const { return walls_; }

 private:
  SmokeState state_;
  double factor_;
  std::shared_ptr<const SmokeLighting> lighting_;
  std::optional<Rgb> walls_;
  std::unique_ptr<WallLight> wallLight_ = std::make_unique<WallLight>();
  Team* holders_;
};

/// A case of smoke on a mesh in a scene.
class SmokeSceneMedium final : public SceneMedium {
 public:
  SmokeSceneMedium(SmokeLayer layer, std::shared_ptr<const SmokeLighting> lighting);

  Result<std::shared_ptr<const MediumAt>> at(const InstantRequest& request,
                                             Progress& progress) override;
  MediumText text(const std::optional<Vec3>& eye) const override;
  nlohmann::ordered_json counts() const override;

  const SmokeLayer& layer() const { return layer_; }

 private:
  SmokeLayer layer_;
  std::shared_ptr<const SmokeLighting> lighting_;
};

const MediumKind& smokeKind();

}  // namespace volute
