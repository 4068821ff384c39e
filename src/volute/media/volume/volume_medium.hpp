// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <mutex>

#include "volute/media/medium_kind.hpp"
#include "volute/media/volume/volume_fields.hpp"
#include "volute/media/volume/volume_layer.hpp"
#include "volute/media/volume/volume_light.hpp"

namespace volute {

/// One frame of a volume, at its place in the scene.
class VolumeAt final : public MediumAt {
 public:
  /// @param factor  of the appearance's extinction
  VolumeAt(const VolumeLayer& layer, std::shared_ptr<const BrickSlice> slice, double moment,
           double factor);

  /// The frame at a position of a tree. Its bricks are only made for who asks for them.
  VolumeAt(const VolumeLayer& layer, std::shared_ptr<const Tree4d> tree, int position,
           double factor);

  /// One that burns or is lit; its light is the same from all cameras.
  VolumeAt(const VolumeLayer& layer, std::shared_ptr<const VolumeLight> light, double moment,
           double factor);

  void addMedia(std::vector<AnyMedium>& media) const override;
  void addExtinction(std::vector<AnyMedium>& media) const override;
  Status addMediaFor(const Camera& camera, std::vector<AnyMedium>& media) const override;
  nlohmann::ordered_json counts() const override;
  /// Of what it emits, unless its appearance says that it lights nothing.
  std::vector<Lamp> lightSources() const override;

  /// Lamps that belong to the picture of it, not to what it holds.
  void setLamps(std::vector<Lamp> lamps) { lamps_ = std::move(lamps); }

  /// Where it scatters light.
  std::shared_ptr<const MediumAt> litBy(const MediaLight& light) const override;

  std::uint64_t memoryBytes() const override;

  /// Null: it is plain emission and extinction of one grid.
  const std::shared_ptr<const VolumeLight>& light() const { return light_; }

  /// Of a unit of its values' extinction, as the picture's law has it.
  double factor() const { return factor_; }

  /// Not yet placed: points are to be turned and moved by placement().
  const VoxelMedium& medium() const;

  /// Null: it is of bricks.
  const std::shared_ptr<const Tree4d>& tree() const { return tree_; }

  int position() const { return position_; }

  const VolumeInfo& info() const { return info_; }

  double emission() const { return emission_; }

  double extinction() const { return extinction_; }

  /// What its bounds leave to do; see VolumeLayer.
  const Placement& placement() const { return placement_; }

  const std::shared_ptr<const BrickSlice>& slice() const;

 private:
  VolumeAt(const VolumeLayer& layer, double moment, double factor);
  /// The same in other light.
  VolumeAt(const VolumeAt& other, std::shared_ptr<const VolumeLight> light);
  AffineMap place() const;
  void addPlaced(AnyMedium medium, std::vector<AnyMedium>& media) const;

  VolumeInfo info_;
  Placement placement_;
  double emission_, extinction_, factor_;
  bool lightsScene_;
  std::vector<Lamp> lamps_;
  std::shared_ptr<const VolumeLight> light_;
  std::shared_ptr<const Tree4d> tree_;
  int position_ = 0;
  mutable std::once_flag made_;
  mutable std::shared_ptr<const BrickSlice> slice_;
  mutable std::optional<VoxelMedium> medium_;
  mutable std::uint64_t nodesVisited_ = 0;
  mutable std::mutex shadedGuard_;
  mutable std::vector<ShadedVoxels> shaded_;  ///< whose counts are asked for
};

/// How a lit or burning volume looks to a camera, in its own space.
ShadedVoxels seenFrom(const VolumeLight& light, const Camera& camera);

/// A volume file in a scene.
class VolumeMedium : public SceneMedium {
 public:
  explicit VolumeMedium(VolumeLayer layer);

  Result<std::shared_ptr<const MediumAt>> at(const InstantRequest& request,
                                             Progress& progress) override;
  bool inMemory(double time) const override;
  std::uint64_t surfacesKey(const InstantRequest& request) const override;
  /// A level set's, grey.
  Status addSurfaces(const InstantRequest& request, TriangleMesh& to) const override;
  /// The cubic basis where a voxel covers more than about 3 pixels, unless a basis is stated.
  void chooseLook(std::span<const Camera> views) override;
  nlohmann::ordered_json counts() const override;
  bool checked() const override;
  Result<std::optional<std::string>> check(Progress& progress) override;

  bool damaged() const override { return damaged_; }

  const VolumeLayer& layer() const { return layer_; }

  /// The grids that its file offers, looked up when first asked for; empty: it has no names.
  const std::vector<std::string>& gridNames() const;

  /// How often values occur in what was shown last, looked up when first asked for.
  const ValueCounts& values() const;

  MediumText text(const std::optional<Vec3>& eye) const override;

  /// What shines at it; in the scene's place.
  void setLighting(VolumeLighting lighting) { lighting_ = std::move(lighting); }

  /// One of the same file in another appearance; what was read serves.
  std::shared_ptr<VolumeMedium> with(const Appearance& appearance) const;

 protected:
  /// What is known of its file, for another one of it.
  void knowAs(const VolumeMedium& other);

 private:
  int rowOf(int position) const;
  Result<std::shared_ptr<const BrickSlice>> coarseSlice(int position, Progress& progress) const;

  /// Splines as finer voxels, where pictures may and memory has room for them; the last is kept.
  std::shared_ptr<const BrickSlice> drawn(std::shared_ptr<const BrickSlice> slice);
  bool refines(const BrickSlice& slice) const;

  /// Of a moment; the last one is kept.
  [[nodiscard]] Result<std::shared_ptr<const VolumeLight>> lightAt(double moment, bool lit);

  VolumeLayer layer_;
  mutable std::optional<std::vector<std::string>> gridNames_;
  mutable std::optional<ValueCounts> values_;
  double moment_ = 0;  ///< shown last
  VolumeLighting lighting_;
  double lightMoment_ = -1;
  bool lightIsWhole_ = false;  // else of the extinction alone
  std::shared_ptr<const VolumeLight> light_;
  std::shared_ptr<const BrickSlice> refinedOf_, refined_;
  bool checked_ = false;  ///< it was looked through for damage
  bool damaged_ = false;
  int block_ = -1;  ///< of the frames of a .volute that are in memory
};

/// A volume drawn on a rectangle that faces the camera, at one instant.
class BillboardAt final : public MediumAt {
 public:
  BillboardAt(std::shared_ptr<const VolumeAt> volume, const BillboardOptions& options)
      : volume_(std::move(volume)), options_(options) {}

  /// Nothing: without a camera there is no rectangle.
  void addMedia(std::vector<AnyMedium>&) const override {}

  Status addMediaFor(const Camera& camera, std::vector<AnyMedium>& media) const override;

  const VolumeAt& volume() const { return *volume_; }

  const BillboardOptions& options() const { return options_; }

 private:
  std::shared_ptr<const VolumeAt> volume_;
  BillboardOptions options_;
};

/// A billboard of a scene.
class BillboardMedium final : public VolumeMedium {
 public:
  BillboardMedium(const VolumeMedium& volume, const SceneBillboard& board);

  Result<std::shared_ptr<const MediumAt>> at(const InstantRequest& request,
                                             Progress& progress) override;

  const BillboardOptions& options() const { return options_; }

 private:
  BillboardOptions options_;
};

const MediumKind& volumeKind();
const MediumKind& billboardKind();

}  // namespace volute
