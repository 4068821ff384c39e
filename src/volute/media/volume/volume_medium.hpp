// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "volute/grid/brick_slice.hpp"
#include "volute/grid/voxel_medium.hpp"
#include "volute/media/field_probe.hpp"
#include "volute/media/medium_kind.hpp"
#include "volute/media/volume/lone_frame.hpp"
#include "volute/media/volume/volume_fields.hpp"
#include "volute/media/volume/volume_light.hpp"
#include "volute/media/volume/volume_motion.hpp"
#include "volute/medium/any_medium.hpp"
#include "volute/tree4d/tree4d.hpp"
#include "volute/volume_files/volume_input.hpp"

namespace volute {

class VolumeMedium;

/// The same values over the basis and at the place that `info` says.
BrickSlice asItLooks(BrickSlice slice, const VolumeInfo& info);

/// One frame of a volume, at its place in the scene.
class VolumeSnapshot final : public MediumSnapshot {
 public:
  /// @param factor  of the appearance's extinction
  VolumeSnapshot(const VolumeMedium& of, std::shared_ptr<const BrickSlice> slice,
                 double framePosition, double factor);

  /// A frame of a tree; its bricks are built on demand.
  VolumeSnapshot(const VolumeMedium& of, std::shared_ptr<const Tree4d> tree, int position,
                 double factor);

  /// One that burns or is lit; its light is the same from all cameras.
  VolumeSnapshot(const VolumeMedium& of, std::shared_ptr<const VolumeLight> light,
                 double framePosition, double factor);

  void addMedia(std::vector<AnyMedium>& media) const override;
  void addExtinction(std::vector<AnyMedium>& media) const override;
  Status addMediaFor(const Camera& camera, std::vector<AnyMedium>& media) const override;
  nlohmann::ordered_json counts() const override;
  /// Of what it emits, unless its appearance says that it lights nothing.
  std::vector<Lamp> lightSources() const override;

  /// Lamps for its own appearance only.
  void setLamps(std::vector<Lamp> lamps) { lamps_ = std::move(lamps); }

  /// The snapshot in another light, where it scatters any.
  std::shared_ptr<const MediumSnapshot> litBy(const MediaLight& light) const override;

  std::uint64_t memoryBytes() const override;

  bool provisional() const override { return provisional_; }

  void setProvisional(bool on) { provisional_ = on; }

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

  /// What its bounds leave to do; see VolumeMedium.
  const Placement& placement() const { return placement_; }

  const std::shared_ptr<const BrickSlice>& slice() const;

 private:
  VolumeSnapshot(const VolumeMedium& of, double framePosition, double factor);
  /// A copy in other light.
  VolumeSnapshot(const VolumeSnapshot& other, std::shared_ptr<const VolumeLight> light);
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
  bool provisional_ = false;
  mutable std::once_flag made_;
  mutable std::shared_ptr<const BrickSlice> slice_;
  mutable std::optional<VoxelMedium> medium_;
  mutable std::uint64_t nodesVisited_ = 0;
  mutable std::mutex shadedGuard_;
  mutable std::vector<ShadedVoxels> shaded_;  ///< whose counts are asked for
};

/// How a lit or burning volume looks to a camera, in its own space.
ShadedVoxels seenFrom(const VolumeLight& light, const Camera& camera);

/// A volume file in a scene. Copies share what was read.
class VolumeMedium : public SceneMedium, public ProbedMedium {
 public:
  /// @param frame  cached data of a single frame; null: none
  [[nodiscard]] static Result<std::shared_ptr<VolumeMedium>> open(
      const std::string& path, const InputOptions& options, const Appearance& appearance,
      Reading& reading, std::shared_ptr<LoneFrame> frame = {});

  Result<std::shared_ptr<const MediumSnapshot>> at(const SnapshotRequest& request,
                                                   Progress& progress) override;
  bool inMemory(double time) const override;
  std::uint64_t surfacesKey(const SnapshotRequest& request) const override;
  /// A level set's, grey.
  Status addSurfaces(const SnapshotRequest& request, TriangleMesh& to) const override;
  /// By what the file says of how much is in its frames.
  Result<std::optional<FirstTime>> firstTime(Progress& progress) override;
  /// The cubic basis where a voxel covers more than about 3 pixels, unless a basis is stated.
  void chooseLook(std::span<const Camera> views) override;
  nlohmann::ordered_json counts() const override;
  bool checked() const override;
  Result<std::optional<std::string>> check(Progress& progress) override;

  bool damaged() const override { return damaged_; }

  /// Along rays. Extinction is not negative: values a little below 0 (overshoots of a solver,
  /// errors of compression) count as 0, and reading a frame that is mostly below is kInvalidData.
  Result<std::unique_ptr<SightField>> sight(Reading& reading) override;

  /// As the file was named when it was opened.
  const std::string& path() const { return path_; }

  /// How it was opened.
  const InputOptions& options() const { return options_; }

  const Appearance& appearance() const { return appearance_; }

  /// Its frames; bounds are those in the scene, but for what the placement does besides.
  const VolumeInfo& volume() const { return volume_; }

  /// The same at a frame position (2.25: a quarter from the third frame to the fourth), and the
  /// turn and offset, without scale, that points within its bounds take. They differ where the
  /// file's grid moves.
  VolumeInfo infoAt(double framePosition) const;
  Placement placementAt(double framePosition) const;

  /// The frame at a frame position as bricks. The last one is kept.
  [[nodiscard]] Result<std::shared_ptr<const BrickSlice>> sliceAt(double framePosition);

  /// The position of the frame shown at a time of the scene [s], with interpolation a fraction:
  /// 2.25 is a quarter of the way from the third frame to the fourth.
  double framePositionAt(double time) const;

  /// The start of a frame in the scene's time [s], and its number in the file.
  double timeOf(int position) const;

  int numberOf(int position) const { return volume_.frameNumbers[position]; }

  FrameScale frameScale() const { return volume_.frameScale; }

  /// The grids that its file offers, looked up when first asked for; empty: it has no names.
  const std::vector<std::string>& gridNames() const;

  /// How often values occur in what was shown last, looked up when first asked for.
  const ValueCounts& values() const;

  MediumText text(const std::optional<Vec3>& eye) const override;
  std::unique_ptr<FieldProbe> fieldProbe() const override;

  /// What shines at it; in the scene's place.
  void setLighting(VolumeLighting lighting) { lighting_ = std::move(lighting); }

  /// The same file with another appearance, reusing the data read so far.
  std::shared_ptr<VolumeMedium> with(const Appearance& appearance) const;

 protected:
  VolumeMedium(const VolumeMedium&) = default;

  /// Its file says how it is turned, mirrored, sheared or moved.
  bool hasPlaces() const { return !input_->places.empty(); }

 private:
  using Slice = std::shared_ptr<const BrickSlice>;

  VolumeMedium(VolumeInput input, const Appearance& appearance);

  MediumInfo describe() const;

  /// Changes appearance, placement or clock without reading again. Only another scale rebuilds the
  /// frame in memory; else bounds stay, and placement_ changes.
  void setAppearance(const Appearance& appearance);

  // ---- where it is

  /// The file's, before the appearance's placement [m].
  const Box3& fileBounds() const { return input_->source->info().bounds; }

  /// The same with its up axis upwards, as the placement finds it [m].
  Box3 uprightBounds() const;
  /// Bounds over all frames in the scene [m]; without far outliers, if these are much larger than
  /// the bounds of nearly all of the volume.
  Box3 boundsInScene() const;
  Mat3 upright() const;
  /// From the own space of a file that has places to its world. Between frames the grid turns and
  /// grows evenly from one to the other; where one mirrors the other it jumps.
  GridMatrix filePlaceAt(double framePosition) const;
  /// From the file's space to the scene's, at a frame position.
  Placement placeAt(double framePosition) const;
  Placement placed(const Appearance& appearance) const;
  /// Finds the bounds of nearly all of the volume if there may be far outliers.
  [[nodiscard]] Status findContent(Progress& progress);
  int positionAt(double time) const;

  // ---- frames

  /// Opens the other grids that the appearance names, so that all have the same voxels.
  [[nodiscard]] Status openOthers(Reading& reading);
  /// A grid of a frame, as volume() says.
  [[nodiscard]] Result<BrickSlice> readSlice(FrameSource& source, int position);
  /// The same at a frame position.
  [[nodiscard]] Result<Slice> readAt(FrameSource& source, double framePosition);
  /// No value of it is below 0; see sight().
  [[nodiscard]] Result<Slice> asExtinction(Slice slice, double framePosition) const;
  /// Whether values below 0 are more than rounding.
  bool clearlyNegative(float least, float most) const;
  /// Tells once that a picture's extinction is below 0 in places.
  void remarkOnNegative(const BrickSlice& slice, double framePosition);
  /// A stored frame; those around the last frame position are kept.
  [[nodiscard]] Result<Slice> frameOf(FrameSource& source, int position);
  /// All bricks of the volume; kTooLarge where they are too many.
  [[nodiscard]] Result<std::vector<BrickPlace>> allBricks(const std::string& why) const;
  /// The frame at a frame position with all that shines or absorbs in it: extinction without the
  /// factor of a picture's law, and emission. The last one is kept. Only for Appearance::shaded().
  [[nodiscard]] Result<Slice> shadedSliceAt(double framePosition);
  /// The colour of the albedo at each light point of a volume of that frame; empty: it has none.
  [[nodiscard]] Result<std::vector<Rgb>> colorsAt(double framePosition,
                                                  std::span<const Vec3> points);
  /// The hexadeca-tree that holds the frame at a position, and others of its blocks. The last one
  /// is kept. kInvalidArgument for what is no .volute.
  [[nodiscard]] Result<std::shared_ptr<const Tree4d>> treeAt(int position);
  int rowOf(int position) const;
  Result<Slice> coarseSlice(int position, Progress& progress) const;
  /// The spline through values where the cubic basis is not the file's own; the slice itself where
  /// it is, and where memory has no room.
  Slice splined(Slice slice) const;
  /// Splines as finer voxels, where pictures may and memory has room for them; the last is kept.
  Slice drawn(Slice slice);
  bool refines(const BrickSlice& slice) const;
  /// Values between frames by velocities, as a trilinear slice.
  static Slice moved(const BrickSlice& slice);
  /// The light at a frame position; the last one is kept.
  [[nodiscard]] Result<std::shared_ptr<const VolumeLight>> lightAt(double framePosition, bool lit,
                                                                   bool moving = false);

  // ---- between frames

  /// Finds out what interpolation is possible, and remarks on it.
  [[nodiscard]] Status chooseInterpolation(Progress& progress);
  /// What the other grids say of the velocities; an error where they are none.
  [[nodiscard]] Status checkVelocities(Reading& reading);
  /// Null where frames go over into each other in place.
  [[nodiscard]] Result<std::shared_ptr<const VoxelPaths>> pathsAt(double framePosition);
  [[nodiscard]] Result<Velocities> velocitiesOf(int position);
  /// From a velocity to its way between the frame at a position and the next one, in the voxels of
  /// the frame at `in` [voxels].
  Mat3 velocityStep(int position, int in, VelocityUnit unit) const;
  /// Says so where two frames fit together in another unit of their velocities.
  [[nodiscard]] Status checkVelocityUnit(double framePosition, const Velocities& before,
                                         const Velocities& after);
  /// From a place among the file's voxels, 0 at the centre of the first, to its world.
  VoxelMap voxelToFile(const GridMatrix& place) const;
  BetweenFrames betweenAt(double framePosition) const;

  /// A tree holds one row of blocks: a still reads no more, and a film of any length needs its
  /// memory.
  static constexpr int kTreeFrames = BlockGrid::kSide;

  struct KeptFrame {
    const FrameSource* source;
    int position;
    Slice slice;
  };

  std::string path_;
  InputOptions options_;
  std::shared_ptr<VolumeInput> input_;  ///< shared by copies: one thread uses them all
  std::map<std::string, std::shared_ptr<VolumeInput>>
      others_;  ///< grids by name; null: it is empty
  std::shared_ptr<LoneFrame> frame_;
  Appearance appearance_;
  Placement placement_;  ///< what volume_.bounds leave to do; nothing where it is not turned and
                         ///< was not moved since it was opened
  VolumeInfo volume_;
  std::optional<Box3> content_;   ///< what holds nearly all, in shares of the bounds
  Progress* progress_ = nullptr;  ///< of the call that is going on
  std::uint64_t maxMemory_ = 0;   ///< [bytes]

  double shown_ = 0;  ///< the last requested frame position
  bool measuresSight_ = false;
  double sliceFramePosition_ = -1;
  Slice slice_;
  double shadedFramePosition_ = -1;
  Slice shadedSlice_;
  Slice drawnOf_, drawn_;
  std::shared_ptr<const Tree4d> tree_;
  int treeBegin_ = 0;
  std::uint64_t treeNodes_ = 0, treeBytes_ = 0;  ///< of the largest tree that was in memory
  int block_ = -1;                               ///< of the frames of a .volute that are in memory

  Interpolation interpolation_ = Interpolation::kNone;  ///< that is done
  std::vector<std::string> velocities_;                 ///< one grid of three channels, or three
  VectorKind vectors_{};                                ///< of the former
  std::vector<KeptFrame> kept_;
  bool velocitiesChecked_ = false;
  bool negativeTold_ = false;
  double negativeSoughtAt_ = -1;  ///< the last frame position that was searched for such values
  float largestSeen_ = 0;         ///< of those that were
  double pathsFramePosition_ = -1;
  std::shared_ptr<const VoxelPaths> paths_;

  VolumeLighting lighting_;
  double lightFramePosition_ = -1;
  bool lightIsWhole_ = false;  ///< else of the extinction alone
  bool lightMoves_ = false;    ///< as SnapshotRequest::moving has it
  std::shared_ptr<const VolumeLight> light_;

  mutable std::optional<std::vector<std::string>> gridNames_;
  mutable std::optional<ValueCounts> values_;
  bool checked_ = false;  ///< it was looked through for damage
  bool damaged_ = false;
};

/// A volume drawn on a rectangle that faces the camera, at one time.
class BillboardSnapshot final : public MediumSnapshot {
 public:
  BillboardSnapshot(std::shared_ptr<const VolumeSnapshot> volume, const BillboardOptions& options)
      : volume_(std::move(volume)), options_(options) {}

  /// Nothing: without a camera there is no rectangle.
  void addMedia(std::vector<AnyMedium>&) const override {}

  Status addMediaFor(const Camera& camera, std::vector<AnyMedium>& media) const override;

  const VolumeSnapshot& volume() const { return *volume_; }

  const BillboardOptions& options() const { return options_; }

 private:
  std::shared_ptr<const VolumeSnapshot> volume_;
  BillboardOptions options_;
};

/// A billboard of a scene.
class BillboardMedium final : public VolumeMedium {
 public:
  BillboardMedium(const VolumeMedium& volume, const SceneBillboard& board);

  Result<std::shared_ptr<const MediumSnapshot>> at(const SnapshotRequest& request,
                                                   Progress& progress) override;

  const BillboardOptions& options() const { return options_; }

 private:
  BillboardOptions options_;
};

const MediumKind& volumeKind();
const MediumKind& billboardKind();

}  // namespace volute
