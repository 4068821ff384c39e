// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "volute/grid/shaded_voxels.hpp"
#include "volute/lighting/illumination.hpp"
#include "volute/media/volume/light_at_surfaces.hpp"
#include "volute/medium/affine_medium.hpp"

namespace volute {

class LightFan;

/// What a volume does with light, and which light there is.
struct VolumeLighting {
  Rgb albedo = Rgb::Zero();  ///< share of the extinguished light that is scattered
  double asymmetry = 0;      ///< g of Henyey and Greenstein's phase function, -1 < g < 1
  std::vector<Lamp> lamps;
  Rgb surrounding = Rgb::Zero();  ///< radiance from everywhere beyond the volume
  TriangleScene surfaces{};       ///< what stands between lamps and volume
  std::vector<Rgb> colors{};      ///< of the albedo, at each light point; empty: none
  bool ownFire = true;            ///< what the volume emits is light for it, too
  bool multiple = false;          ///< light is scattered more than once: DiffuseLight
  bool firstSky = false;          ///< the surrounding as the first format of scenes has it
  bool fewSky = false;            ///< the surrounding as large volumes have it
  AffineMap place{};              ///< from the volume's own space to that of lamps and views
};

/// Single scattering in a volume at one time:
///   L(x, w) = albedo (sum over lamps of E(x) exp(-t(x, lamp)) V phase + A(x) + F(x))
/// with E a lamp's irradiance where nothing is in the way, its mean in a voxel near a smaller lamp,
/// t the volume's own optical depth towards it at the centre of every voxel: exact, or by LightFan,
/// exact on rays as close as voxels, but for voxels beside others that are nearly solid. A, the
/// share of an even surrounding that arrives, is a mean over 100 directions by fans or 26 by rays,
/// at each voxel, or every second, or over 50 at every fourth of a large volume, whose extinction
/// is taken from voxels of twice the edges; F, what its own fire sends, a sum over the bricks that
/// emit, each as a point, at every fourth. Both are scattered evenly.
///
/// Threads may share it.
class VolumeLight {
 public:
  VolumeLight(ShadedVoxels volume, VolumeLighting lighting);

  using View = VolumeView;

  /// Finds the light that does not depend on a view; the first view would else do so.
  void prepare() const { gather(), again(), atSurfaces(); }

  /// Before surfaces the light is that of points before them: LightAtSurfaces.
  ShadedVoxels seenFrom(const View& view) const;

  /// Without a direction: scattered evenly, and interpolated through surfaces.
  ShadedVoxels seen() const;

  /// About what it takes, with its light and one view of it.
  std::uint64_t memoryBytes() const;

  /// Where a volume's fire is, and how strong: lamps that shine everywhere, for whole bricks, or
  /// for cubes of them where there would be more than `most`.
  /// @param slice  one channel or three of light, or four, of which the last three are
  /// @param place  of the volume; the lamps are in the world
  /// @param scale  [radiance/m] of a unit
  static std::vector<Lamp> lampsOf(const BrickSlice& slice, const AffineMap& place, double scale,
                                   std::size_t most);

  /// The same in the light of more lamps; the last one is kept.
  /// @param between  other media that all lamps' light passes through
  std::shared_ptr<const VolumeLight> withLamps(std::span<const Lamp> lamps,
                                               std::span<const AnyMedium> between = {}) const;

  const VolumeLighting& lighting() const { return lighting_; }

  /// Without the light.
  const ShadedVoxels& volume() const { return volume_; }

  const BrickSlice& slice() const { return volume_.slice(); }

 private:
  using Place = std::array<std::int32_t, 3>;
  class Lattice;

  void gather() const;
  void addShares(std::size_t lamp, const ArrivingLight& arriving) const;
  const std::vector<bool>& atSolid() const;
  bool fanned(const LightFan& fan, const Lamp& lamp, std::span<float> out,
              std::span<float> beyond = {}) const;

  /// Place of a voxel in the world [m].
  Vec3 placeOf(const Place& voxel) const {
    return lighting_.place.toWorld(volume_.centreOf(voxel));
  }

  std::vector<Lamp> fires() const;
  std::shared_ptr<const Lattice> sky() const;
  void addRays(std::span<const Lamp> lamps, Lattice& lattice) const;
  Mat3 halfVoxel() const;
  Vec3 edges() const;
  void findSpreads() const;
  Box3 bounds() const;
  AnyMedium medium() const;
  Illumination illumination() const;
  const DiffuseLight* again() const;
  template <class ShareOf>
  Rgb ofLamps(const Place& place, const std::optional<View>& view, bool again,
              ShareOf&& shareOf) const;
  const std::shared_ptr<const LightAtSurfaces>& atSurfaces() const;
  ShadedVoxels shaded(const std::optional<View>& view) const;
  std::vector<VoxelLight> scattered(const std::optional<View>& view) const;
  void hide(const View& view, std::vector<VoxelLight>& light) const;

  ShadedVoxels volume_;
  VolumeLighting lighting_;
  std::vector<AnyMedium> between_;
  mutable std::once_flag gathered_, scattered_, beside_, foundSolid_;
  mutable std::vector<bool> atSolid_;                   ///< of each light point; empty: none is
  mutable std::vector<std::vector<float>> lampShares_;  ///< of each lamp, at each light point: 0..1
  mutable std::vector<double> spreads_;  ///< around each lamp [m2]: voxels with means of its light
  mutable std::shared_ptr<const DiffuseLight> again_;          ///< null: light is scattered once
  mutable std::vector<std::shared_ptr<const Lattice>> even_;   ///< A and F, where they are there
  mutable std::shared_ptr<const LightAtSurfaces> atSurfaces_;  ///< null: there are none
  mutable std::mutex guard_;
  mutable std::shared_ptr<const VolumeLight> inMore_;  ///< withLamps()
  mutable std::optional<View> lastView_;
  mutable std::optional<ShadedVoxels> last_;
  mutable std::vector<VoxelLight> unhidden_;  ///< scattered evenly, before hide()
};

}  // namespace volute
