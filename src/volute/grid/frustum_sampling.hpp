// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/grid/grid_matrix.hpp"
#include "volute/grid/volume_info.hpp"

namespace volute {

/// Has grids whose voxels widen with the distance (frusta) read as voxels of a lattice. Trivially
/// copyable: it crosses to the process that reads the file.
struct FrustumSampling {
  GridMatrix indexToWorld{};  ///< of the lattice; zeros: cubes as small as the voxels in its middle
  Basis basis = Basis::kTrilinear;
};

}  // namespace volute
