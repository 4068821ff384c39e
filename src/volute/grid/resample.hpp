// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "volute/grid/bricks.hpp"
#include "volute/grid/frame_source.hpp"
#include "volute/grid/grid_matrix.hpp"

namespace volute {

/// From the indices of one lattice of voxels to those of another one, and back. Planes stay planes.
class LatticeMap {
 public:
  virtual ~LatticeMap() = default;

  virtual Vec3 toOld(const Vec3& index) const = 0;
  virtual Vec3 toNew(const Vec3& index) const = 0;
};

/// A map between lattices with an affine matrix each.
class AffineLattices final : public LatticeMap {
 public:
  AffineLattices(const GridMatrix& oldToWorld, const GridMatrix& newToWorld)
      : linear_(linearOf(oldToWorld).inverse() * linearOf(newToWorld)),
        offset_(linearOf(oldToWorld).inverse() * (offsetOf(newToWorld) - offsetOf(oldToWorld))),
        back_(linear_.inverse()) {}

  Vec3 toOld(const Vec3& index) const override { return linear_ * index + offset_; }

  Vec3 toNew(const Vec3& index) const override { return back_ * (index - offset_); }

  const Mat3& linear() const { return linear_; }

  const Vec3& offset() const { return offset_; }

 private:
  Mat3 linear_;
  Vec3 offset_;
  Mat3 back_;
};

/// Where the components of vectors are: at the voxels' centres, or each in the middle of the face
/// before it along its own axis (staggered).
enum class Components { kAtCentres, kAtFaces, kFacesToCentres };

/// What is in `bricks` on another lattice. A new voxel has the value of the basis at its centre,
/// or, where it is larger than old ones, the mean over the centres of as many parts of it along
/// each axis as it is long in old voxels, 16 at most. It is active where an active voxel counts in
/// that. kTooLarge where more than `maxMemory` would be taken.
/// @param bricks  after sort()
/// @param box  of new voxels; the rest is left out
/// @param components  of three channels
[[nodiscard]] Result<Bricks> resampled(const Bricks& bricks, const LatticeMap& map,
                                       const IndexBox& box, Basis basis, std::uint64_t maxMemory,
                                       Components components = Components::kAtCentres);

/// A lattice of voxels and a part of it.
struct Lattice {
  GridMatrix indexToWorld{};
  IndexBox box{};
};

/// Voxels of a frame that are not background, and how many of them have their centre outside of a
/// lattice's box.
struct VoxelsCut {
  std::uint64_t all = 0;
  std::uint64_t outside = 0;
};

/// The frames of `source` on another lattice. Where that is the same one, or moved by whole voxels,
/// its bricks stay as they are. Its bounds are in spaceOf(lattice.indexToWorld).
/// @param places  of the source, as PlacedFrames has them
/// @param turns  of the vectors in it, in each frame; empty: they are the same on the new lattice
/// @param components  of three channels; kAtFaces for lattices along the same axes alone
/// @param onCut  called for each frame that is read from its first layer on, by any thread; may be
///               empty
std::unique_ptr<FrameSource> resampleTo(std::unique_ptr<FrameSource> source,
                                        std::vector<GridMatrix> places, const Lattice& lattice,
                                        Basis basis, std::uint64_t maxMemory,
                                        std::vector<Mat3> turns = {},
                                        std::function<void(int, const VoxelsCut&)> onCut = {},
                                        Components components = Components::kAtCentres);

/// From the index of a volume's first voxel to the world in a frame.
/// @param places  as PlacedFrames has them
GridMatrix indexToWorld(const VolumeInfo& info, const std::vector<GridMatrix>& places,
                        std::size_t frame);

}  // namespace volute
