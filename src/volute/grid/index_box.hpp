// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>

namespace volute {

/// The place of a voxel on an endless lattice, axes in the order x, y, z.
using VoxelIndex = std::array<std::int64_t, 3>;

/// A half-open box of voxel indices, axes in the order x, y, z.
struct IndexBox {
  VoxelIndex begin{};
  VoxelIndex end{};

  bool empty() const { return end[0] <= begin[0] || end[1] <= begin[1] || end[2] <= begin[2]; }

  std::int64_t size(int axis) const { return end[axis] - begin[axis]; }

  bool contains(const IndexBox& other) const;
  bool contains(const VoxelIndex& voxel) const;
  void extend(const IndexBox& other);  ///< the least box around both; an empty one adds nothing
  IndexBox shifted(const VoxelIndex& by) const;
  IndexBox intersection(const IndexBox& other) const;

  bool operator==(const IndexBox&) const = default;
};

}  // namespace volute
