// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "volute/base/half.hpp"
#include "volute/grid/cubic_voxels.hpp"
#include "volute/grid/voxel_medium.hpp"
#include "volute/grid/voxel_places.hpp"

namespace volute {

/// Light at a voxel.
using VoxelLight = ArrayN<float, 3>;

/// One snapshot of a volume that absorbs, may send light of its own, and may scatter light that
/// reaches it:
///   extinction = K,   emission = J + K * L
/// with K [1/m], J [radiance/m] and L, the light that a unit of extinction scatters towards the eye
/// [radiance], each interpolated between voxel centres; K and J fall to zero one voxel beyond the
/// outer ones. So the light along a ray is exact for the three: pieces() has them as polynomials.
///
/// Over the cubic basis K and J are splines, and so is what is scattered: its coefficients are
/// those whose spline is that of K times L to the fourth order of the voxels' size.
///
/// A Medium and FastMedium. Cheap to copy: what it holds is shared and const.
class ShadedVoxels {
 public:
  /// @param slice  of the trilinear or the cubic basis, in channels K, or K and J's red, green and
  /// blue; K >= 0. It scatters nothing.
  explicit ShadedVoxels(std::shared_ptr<const BrickSlice> slice);

  /// Splines for pictures: lit at voxels' centres through smoothedSpline(), and drawn(), with or
  /// without light, as refinedSpline(). Several times faster than the cubic basis.
  static ShadedVoxels refining(std::shared_ptr<const BrickSlice> spline);

  /// Where bricks of cells of one value lie together, and are `many`, 4 million voxels, as in tiles
  /// of OpenVDB, light is known at every fourth voxel. For lamps whose light changes slowly there.
  /// Only without J, over the trilinear basis; march() is null then. Else as ShadedVoxels(slice).
  static ShadedVoxels withTiles(std::shared_ptr<const BrickSlice> slice, std::size_t many = 8192);

  /// What is drawn where no light was given: itself, unless it is refining().
  ShadedVoxels drawn() const;

  /// What that takes, besides what is here [bytes].
  std::uint64_t drawnBytes() const;

  /// Where light is to be known: the centres of all voxels in cells in which K is not zero, up to
  /// one voxel outside of the volume [m]; over the cubic basis those of voxels with K > 0. Of
  /// tiles every fourth.
  std::vector<Vec3> lightPoints() const;

  /// The same as voxels; -1 is one before the first.
  VoxelPlaces lightPlaces() const;

  /// Which of these a voxel is; -1: none. Not of tiles.
  std::int32_t lightPointAt(const std::array<std::int32_t, 3>& voxel) const;

  /// [m]
  Vec3 centreOf(const std::array<std::int32_t, 3>& place) const;

  /// Made by refining(): drawn over splines.
  bool refines() const { return splines_ != nullptr; }

  /// From light at each of lightPoints() what L is to be there, so that between them its means are
  /// right to the fourth order: less a twelfth of its second differences. What is interpolated
  /// between values of e^-t would else be too bright everywhere. Where there is no smoke, it is
  /// less by how much the smoke beside is in a shadow that is not its own: else a voxel in the sun
  /// would light it. Over the cubic basis it is the light itself.
  /// @param edges  lengths of a voxel's edges [m]
  std::vector<VoxelLight> forMeans(std::span<const VoxelLight> light, const Vec3& edges) const;

  /// withLight() of forMeans(), with less memory.
  ShadedVoxels withMeansOf(std::vector<VoxelLight> light, const Vec3& edges) const;

  /// The same with light: L at each of lightPoints().
  ShadedVoxels withLight(std::vector<VoxelLight> light) const;

  Box3 bounds() const;

  double extinction(const Vec3& point) const { return absorption().extinction(point); }

  Rgb emission(const Vec3& point) const;

  void opticalDepth(std::span<const Segment> segments, std::span<double> depths) const {
    absorption().opticalDepth(segments, depths);
  }

  /// One for each cell that is not all zero.
  void pieces(std::span<const Segment> segments, std::span<std::vector<Piece>> pieces) const;

  /// In float and SIMD: two Gauss points for each step of an optical depth of at most 1.3, and
  /// light as 11, 11 and 10 bits of its square root; within 1e-3 of the brightest of the pieces'
  /// light. A ray that has lost all but 1e-4 of its light ends there.
  void radiance(std::span<const Segment> segments, std::span<Radiance> out) const;

  /// What absorbs in it, and sends nothing: for light on its way to somewhere.
  const VoxelMedium& absorption() const;

  /// K, and J where there is one.
  const BrickSlice& slice() const { return *slice_; }

  MarchCounts counts() const;

  /// What the SIMD march reads, for its twins on other devices. Null where its values and light are
  /// too many to be addressed, and where there are tiles.
  std::shared_ptr<const MarchGrid> march() const {
    return tiles_ || !layout_ || (light_ && !marchesLight()) ? nullptr : marched();
  }

 private:
  class Values;

  /// @param without  bricks of cells that are not marched through; null: none
  ShadedVoxels(std::shared_ptr<const BrickSlice> whole, const BrickTable* without);
  bool marchesLight() const;
  std::shared_ptr<const MarchGrid> marched() const;

  /// Corners of cells at which light is computed.
  struct Corners {
    std::vector<BrickCorners> ofBrick;                ///< of bricks of cells
    std::vector<std::array<std::int32_t, 3>> places;  ///< voxels behind those
    std::vector<std::int32_t>
        ofVoxel;  ///< cubic: which of the places is at each, of stored bricks; or -1

    /// Which of the places is a corner of a brick; -1: none.
    std::int32_t pointAt(const MarchGrid& grid, std::size_t brick, int corner) const;

    /// Positions of all corners of a cell in the list of points.
    std::array<std::int32_t, CornerSet::kCorners> pointsOf(const MarchGrid& grid,
                                                           std::size_t brick) const;
  };

  struct Counters;
  struct Tiles;

  static std::shared_ptr<const Corners> findCentres(const BrickSlice& slice);

  /// withLight() over the cubic basis.
  ShadedVoxels withSplines(std::span<const VoxelLight> light) const;

  /// The coefficients of what is sent and scattered.
  BrickSlice litSplines(const BrickSlice& splines, std::span<const VoxelLight> light) const;

  /// Refined splines, which take no light of their own.
  ShadedVoxels drawnFrom(const BrickSlice& splines) const;

  /// Light as shares of the brightest: of each colour, in 6 bytes; of one colour in 4, exactly.
  class PackedLight {
   public:
    PackedLight(const VoxelLight& brightest, bool oneColor, std::size_t count)
        : brightest_(brightest), colors_(oneColor ? 0 : count), shares_(oneColor ? count : 0) {
      brightest.maxCoeff(&main_);
    }

    bool oneColor() const { return colors_.empty(); }

    std::size_t size() const { return oneColor() ? shares_.size() : colors_.size(); }

    void set(std::size_t i, const VoxelLight& light) {
      if (oneColor()) {
        shares_[i] = light[main_] / brightest_[main_];
        return;
      }
      for (std::size_t c = 0; c < 3; ++c)
        colors_[i][c] = toHalf(light[c] / std::max(brightest_[c], 1e-30F));
    }

    VoxelLight at(std::int32_t i) const {
      if (oneColor())
        return brightest_ * shares_[static_cast<std::size_t>(i)];
      const std::array<Half, 3>& share = colors_[static_cast<std::size_t>(i)];
      return brightest_ * VoxelLight(toFloat(share[0]), toFloat(share[1]), toFloat(share[2]));
    }

   private:
    VoxelLight brightest_;
    int main_ = 0;  ///< the brightest one
    std::vector<std::array<Half, 3>> colors_;
    std::vector<float> shares_;
  };

  ShadedVoxels withPacked(std::shared_ptr<const PackedLight> light) const;

  /// Which of the places is this voxel; -1: none.
  std::int32_t pointAt(const std::array<std::int32_t, 3>& voxel) const;

  static std::shared_ptr<Corners> findCorners(const MarchGrid& grid);
  static std::shared_ptr<Tiles> findTiles(const BrickSlice& slice);

  /// Gives the corners of tiles their places, behind those of other cells.
  void addCorners(Tiles& tiles, Corners& corners) const;

  /// Of a light point without smoke beside smoke.
  VoxelLight atRim(const std::array<std::int32_t, 3>& place, std::size_t point,
                   std::span<const VoxelLight> light, const Vec3& edges) const;

  /// Calls put(i, light) for each place, as forMeans() says.
  template <class Put>
  void eachMean(std::span<const VoxelLight> light, const Vec3& edges, Put&& put) const;

  /// The same for the places that only tiles have.
  template <class Put>
  void eachMeanOfTiles(std::span<const VoxelLight> light, Put&& put) const;

  CellGrid tileGrid() const;

  /// Appends the pieces of tiles.
  void addTilePieces(const Segment& segment, std::vector<Piece>& pieces) const;

  /// A ray in a tile.
  struct OnTile {
    std::int32_t number = 0;
    double begin = 0, end = 0;
    bool begins = false;  ///< there is something else before it, or a gap
  };

  Radiance radianceOfTile(const OnTile& on, const Segment& segment) const;

  /// From tile to tile, and by the march between them.
  void radianceWithTiles(std::span<const Segment> segments, std::span<Radiance> out,
                         MarchCounts& counts) const;

  /// L at a corner of a cell in a brick; 0 where it is not known.
  Rgb lightAt(std::int32_t brick, const std::array<int, 3>& cell, int corner) const;

  std::shared_ptr<const BrickSlice> slice_;
  std::shared_ptr<const BrickSlice> splines_{};  ///< of which slice_ is smoothed; or null
  CellGrid cells_;
  CellRange occupied_;
  std::shared_ptr<const MarchGrid> layout_;   ///< which bricks are marched through; null: cubic
  std::shared_ptr<const MarchGrid> lit_;      ///< the same with values and light; or null
  std::shared_ptr<const Values> values_;      ///< without light
  std::shared_ptr<const CubicVoxels> cubic_;  ///< of K and emission; null: trilinear
  std::shared_ptr<const Corners> corners_;
  std::shared_ptr<const Tiles> tiles_;        ///< null: there are none
  std::shared_ptr<const PackedLight> light_;  ///< at the places; or null
  std::shared_ptr<Counters> counters_;
};

}  // namespace volute
