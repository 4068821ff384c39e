// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <map>
#include <memory>
#include <string>

#include "volute/geometry/triangle_scene.hpp"
#include "volute/grid/brick_slice.hpp"
#include "volute/grid/voxel_medium.hpp"
#include "volute/media/clock.hpp"
#include "volute/media/placement.hpp"
#include "volute/media/volume/transfer.hpp"
#include "volute/media/volume/volume_motion.hpp"
#include "volute/medium/any_medium.hpp"
#include "volute/tree4d/tree4d.hpp"
#include "volute/volume_files/volume_input.hpp"

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

/// How much of the hexadeca-tree a rendering has looked at.
struct TreeCounts {
  std::uint64_t nodes = 0;         ///< of the largest tree that was in memory at a time
  std::uint64_t treeBytes = 0;     ///< of that tree
  std::uint64_t nodesVisited = 0;  ///< summed over all frames
};

/// What a tree gave, over the basis and at the place that `info` says.
BrickSlice asItLooks(BrickSlice slice, const VolumeInfo& info);

/// A volume file that is shown: gives any of its frames. Copies share what was read.
class VolumeLayer {
 public:
  [[nodiscard]] static Result<VolumeLayer> open(const std::string& path,
                                                const InputOptions& options,
                                                const Appearance& appearance, Reading& reading);

  /// Its bounds are those in the scene, but for what placement() does besides.
  const VolumeInfo& info() const { return info_; }

  /// As the file was named when it was opened.
  const std::string& path() const { return path_; }

  std::uint64_t maxMemory() const { return maxMemory_; }  ///< [bytes]

  /// The file's own; box where it states none.
  Basis fileBasis() const { return input_->source->info().basis; }

  /// The file's, before the appearance's placement [m].
  const Box3& fileBounds() const { return input_->source->info().bounds; }

  /// Whether its values are distances to a surface; the inside is drawn unless the surface is.
  bool isLevelSet() const { return input_->source->info().levelSet; }

  /// The same with its up axis upwards, as the placement finds it [m].
  Box3 uprightBounds() const;

  /// What it takes in the scene in any frame [m]; where that is much more than what nearly all of
  /// it is in, the latter.
  Box3 boundsInScene() const;

  /// Its file says how it is turned, mirrored, sheared or moved.
  bool hasPlaces() const { return !input_->places.empty(); }

  /// info() and placement() at a moment, which differ where the file's grid moves.
  VolumeInfo infoAt(double moment) const;
  Placement placementAt(double moment) const;

  /// It looks otherwise from now on, or is elsewhere, or at another time: nothing is read again for
  /// that. A frame that is held is made again only where the scale is another; else bounds stay
  /// what they are, and placement() moves.
  void setAppearance(const Appearance& appearance);

  /// The frame at a moment as bricks. The last one is kept.
  /// @param tree  from the hexadeca-tree, which rounds once more, not from the file's own values;
  /// of a position
  [[nodiscard]] Result<std::shared_ptr<const BrickSlice>> sliceAt(double moment, bool tree = false);

  /// The hexadeca-tree that holds the frame at a position, and others of its blocks. The last one
  /// is kept. kInvalidArgument for what is no .volute.
  [[nodiscard]] Result<std::shared_ptr<const Tree4d>> treeAt(int position);

  /// The frame at a moment with all that shines or absorbs in it: extinction without the factor
  /// of a picture's law, and emission. The last one is kept. Only for appearance().shaded().
  [[nodiscard]] Result<std::shared_ptr<const BrickSlice>> shadedSliceAt(double moment);

  /// The colour of the albedo at each light point of a volume of that frame; empty: it has none.
  [[nodiscard]] Result<std::vector<Rgb>> colorsAt(double moment, std::span<const Vec3> points);

  /// What is to be done to points within info().bounds: turn and offset, no scale. Nothing for a
  /// volume that is not turned, and was not moved since it was opened: its bounds say where it is.
  const Placement& placement() const { return placement_; }

  /// What was read of trees so far; zeros for inputs without one.
  const TreeCounts& treeCounts() const { return counts_; }

  /// The position of the frame that is shown at a time of the scene [s], or was last.
  int positionAt(double time) const;

  /// That position and, where it is asked to be interpolated, the share of the way to the next one
  /// that has gone by: 2.25 is a quarter from the third to the fourth.
  double momentAt(double time) const;

  bool interpolates() const { return interpolation_ != Interpolation::kNone; }

  /// What the file calls a frame.
  int numberOf(int position) const { return info_.frameNumbers[position]; }

  FrameScale frameScale() const { return info_.frameScale; }

  /// When a frame begins in the scene's time [s].
  double timeOf(int position) const;

  /// Who hears of later reads, instead of the reading that it was opened in.
  void setProgress(Progress& progress) { progress_ = &progress; }

  const Appearance& appearance() const { return appearance_; }

  /// Appends the surface of a level set's frame, in the scene.
  [[nodiscard]] Status addSurface(int position, std::uint32_t material,
                                  std::vector<Triangle>& triangles) const;

  /// Null unless it is a .volute file.
  const VoluteReader* reader() const { return input_->reader.get(); }

  /// How it was opened.
  const InputOptions& options() const { return options_; }

 private:
  VolumeLayer(VolumeInput input, const Appearance& appearance);

  /// Looks for what holds nearly all where something may be far away from it.
  [[nodiscard]] Status findContent(Progress& progress);

  /// Opens the other grids that the appearance names, so that all have the same voxels.
  [[nodiscard]] Status openOthers(Reading& reading);
  using Slice = std::shared_ptr<const BrickSlice>;

  /// A grid of a frame, as the layer's info says.
  [[nodiscard]] Result<BrickSlice> readSlice(FrameSource& source, int position);
  /// The same at a moment.
  [[nodiscard]] Result<Slice> readAt(FrameSource& source, double moment);
  /// All bricks of the volume; kTooLarge where they are too many.
  [[nodiscard]] Result<std::vector<BrickPlace>> allBricks(const std::string& why) const;

  /// Finds out what interpolation is possible, and remarks on it.
  [[nodiscard]] Status chooseInterpolation(Progress& progress);
  /// A stored frame; those around the last moment are kept.
  [[nodiscard]] Result<Slice> frameOf(FrameSource& source, int position);
  /// Null where frames go over into each other in place.
  [[nodiscard]] Result<std::shared_ptr<const VoxelPaths>> pathsAt(double moment);
  [[nodiscard]] Result<Velocities> velocitiesOf(int position);
  /// From a velocity to its way between the frame at a position and the next one, in the voxels of
  /// the frame at `in` [voxels].
  Mat3 velocityStep(int position, int in) const;
  /// From a place among the file's voxels, 0 at the centre of the first, to its world.
  VoxelMap voxelToFile(const GridMatrix& place) const;
  BetweenFrames instantAt(double moment) const;
  /// What the other grids say of the velocities; an error where they are none.
  [[nodiscard]] Status checkVelocities(Reading& reading);

  [[nodiscard]] Result<BrickSlice> sliceFromTree(int position);

  /// A tree holds one row of blocks: a still reads no more, and a film of any length needs its
  /// memory.
  static constexpr int kTreeFrames = BlockGrid::kSide;

  Mat3 upright() const;
  /// From the own space of a file that has places to its world. Between frames the grid turns and
  /// grows evenly from one to the other; where one mirrors the other it jumps.
  GridMatrix filePlaceAt(double moment) const;
  /// The same to the scene.
  Placement placeAt(double moment) const;
  Placement placed(const Appearance& appearance) const;

  std::string path_;
  InputOptions options_;
  std::shared_ptr<VolumeInput> input_;  ///< shared by copies: one thread uses them all
  Appearance appearance_;
  Placement placement_;  ///< what info_.bounds leave to do
  VolumeInfo info_;
  std::optional<Box3> content_;  ///< what holds nearly all, in shares of the bounds
  std::shared_ptr<const Tree4d> tree_;
  int treeBegin_ = 0;
  TreeCounts counts_;
  Progress* progress_ = nullptr;
  std::uint64_t maxMemory_ = 0;
  double moment_ = -1;
  bool fromTree_ = false;  ///< slice_ is
  std::shared_ptr<const BrickSlice> slice_;
  std::map<std::string, std::shared_ptr<VolumeInput>>
      others_;  ///< grids by name; null: it is empty
  double shadedMoment_ = -1;
  std::shared_ptr<const BrickSlice> shadedSlice_;

  struct KeptFrame {
    const FrameSource* source;
    int position;
    std::shared_ptr<const BrickSlice> slice;
  };

  Interpolation interpolation_ = Interpolation::kNone;  ///< that is done
  std::vector<std::string> velocities_;                 ///< one grid of three channels, or three
  VectorKind vectors_{};                                ///< of the former
  std::vector<KeptFrame> kept_;
  double pathsMoment_ = -1;
  std::shared_ptr<const VoxelPaths> paths_;
};

}  // namespace volute
