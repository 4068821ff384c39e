// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>

#include "volute/media/fds/fds_layer.hpp"
#include "volute/media/medium_kind.hpp"

namespace volute {

/// Whose ranks hold the meshes of a case together.
struct FdsShares {
  Team* holders = nullptr;
  double scale = 1;     ///< the smoke is so many times as thick as the files say, whatever the law
  bool shines = false;  ///< FdsLayer::shines(), the same on all ranks
};

/// Smoke and fire of an FDS case at one instant.
class FdsAt final : public MediumAt {
 public:
  /// The smoke in the light and the shadow of other media.
  using Relit = std::function<Result<FdsField>(const FdsField& smoke, const MediaLight& light)>;

  /// @param factor  of the smoke's extinction and of what it scatters
  /// @param shares  nothing: this process holds all
  FdsAt(FdsField smoke, double factor, std::optional<FdsFlame> fire, std::vector<AnyMedium> sheets,
        std::optional<FdsShares> shares = {}, Relit relit = {})
      : smoke_(std::move(smoke)),
        factor_(factor),
        fire_(std::move(fire)),
        sheets_(std::move(sheets)),
        shares_(shares),
        relit_(std::move(relit)) {}

  void addMedia(std::vector<AnyMedium>& media) const override;

  /// Where this process holds all of it.
  std::shared_ptr<const MediumAt> litBy(const MediaLight& light) const override;

  bool drawsItself() const override { return shares_.has_value(); }

  /// Where ranks hold shares, what draws them together.
  std::shared_ptr<MediumPicture> picture(std::shared_ptr<MediumPicture> earlier) const override;

  const FdsField& smoke() const { return smoke_; }

  double factor() const { return factor_; }

  /// Which shines and hides nothing; nothing where there is none.
  const std::optional<FdsFlame>& fire() const { return fire_; }

  /// Translucent surfaces.
  std::span<const AnyMedium> sheets() const { return sheets_; }

 private:
  FdsField smoke_;
  double factor_;
  std::optional<FdsFlame> fire_;
  std::vector<AnyMedium> sheets_;
  std::optional<FdsShares> shares_;
  Relit relit_;
};

/// An FDS case in a scene: smoke, fire and the building.
class FdsSceneMedium final : public SceneMedium {
 public:
  explicit FdsSceneMedium(FdsLayer layer);

  Result<std::shared_ptr<const MediumAt>> at(const InstantRequest& request,
                                             Progress& progress) override;

  /// All cases have a building, so never 0.
  std::uint64_t surfacesKey(const InstantRequest& request) const override {
    return 1 + layer_.surfacesAt(request.time, request.eye);
  }

  Status addSurfaces(const InstantRequest& request, TriangleMesh& to) const override {
    return layer_.addSurfaces(request.time, request.eye, to);
  }

  MediumText text(const std::optional<Vec3>& eye) const override;

  std::optional<CameraDescription> firstCamera() const override { return layer_.firstCamera(); }

  Result<std::optional<FirstTime>> firstTime(Progress& progress) override;

  const FdsLayer& layer() const { return layer_; }

 private:
  FdsLayer layer_;
};

const MediumKind& fdsKind();

}  // namespace volute
