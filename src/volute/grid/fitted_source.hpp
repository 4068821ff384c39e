// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <memory>

#include "volute/grid/frame_source.hpp"

namespace volute {

/// Whether the voxels of `a` are some of those of `b`'s lattice: of one size, and apart by whole
/// voxels, to a thousandth of one.
bool onOneLattice(const VolumeInfo& a, const VolumeInfo& b);

/// `source` over the voxels of `lattice` (its size and bounds count). Values of voxels that both
/// have are copied; on another lattice they are interpolated between the centres of voxels, and
/// where the new voxels are larger, averaged over each.
/// @param outside  of each channel, where the source has no voxels
std::unique_ptr<FrameSource> fitTo(std::unique_ptr<FrameSource> source, const VolumeInfo& lattice,
                                   const std::array<double, 3>& outside = {});

/// `info` with voxels added on all sides until it holds `box` [m].
VolumeInfo widenedTo(const VolumeInfo& info, const Box3& box);

}  // namespace volute
