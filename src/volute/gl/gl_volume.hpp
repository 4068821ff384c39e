// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>

#include "volute/grid/brick_slice.hpp"
#include "volute/tree4d/tree4d.hpp"

namespace volute {

class GlPart;

/// VoxelMedium's twin: one snapshot of a volume, from an atlas of its bricks on the device.
struct GlVolume {
  std::shared_ptr<const BrickSlice> slice;
  double emission = 1;           ///< radiance per metre per unit
  double extinction = 0;         ///< 1/m per unit
  Mat3 turn = Mat3::Identity();  ///< linear; points of the slice are turned by it, then moved
  Vec3 offset = Vec3::Zero();    ///< [m]
};

/// What rays through a tree step over, so that no voxel of it is walked for.
enum class GlTreeSkip {
  kNothing,  ///< no voxel
  kBox,      ///< what is outside the box of the snapshot's bricks that are not empty
  kBricks,   ///< that, and the bricks in it that are empty
};

/// The same, but the hexadeca-tree itself is on the device and each voxel is a walk in it
/// (Ahrenberg et al. 2005, Figures 5 and 6): no time is spent on the snapshot, more on each ray.
struct GlTreeVolume {
  std::shared_ptr<const Tree4d> tree;
  int frame = 0;
  Basis basis = Basis::kBox;
  Box3 bounds;  ///< outer voxel faces [m]
  double emission = 1;
  double extinction = 0;
  Mat3 turn = Mat3::Identity();           ///< as GlVolume's
  Vec3 offset = Vec3::Zero();             ///< [m]
  GlTreeSkip skip = GlTreeSkip::kBricks;  ///< the picture is the same
};

std::shared_ptr<const GlPart> glPart(GlVolume volume);
std::shared_ptr<const GlPart> glPart(GlTreeVolume volume);

}  // namespace volute
