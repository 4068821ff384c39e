// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/index_box.hpp"

#include <algorithm>

namespace volute {

bool IndexBox::contains(const IndexBox& other) const {
  if (other.empty())
    return true;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (other.begin[axis] < begin[axis] || other.end[axis] > end[axis])
      return false;
  }
  return true;
}

bool IndexBox::contains(const VoxelIndex& voxel) const {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (voxel[axis] < begin[axis] || voxel[axis] >= end[axis])
      return false;
  }
  return true;
}

void IndexBox::extend(const IndexBox& other) {
  if (other.empty())
    return;
  if (empty()) {
    *this = other;
    return;
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    begin[axis] = std::min(begin[axis], other.begin[axis]);
    end[axis] = std::max(end[axis], other.end[axis]);
  }
}

IndexBox IndexBox::shifted(const VoxelIndex& by) const {
  IndexBox result = *this;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    result.begin[axis] += by[axis];
    result.end[axis] += by[axis];
  }
  return result;
}

IndexBox IndexBox::intersection(const IndexBox& other) const {
  IndexBox result;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    result.begin[axis] = std::max(begin[axis], other.begin[axis]);
    result.end[axis] = std::min(end[axis], other.end[axis]);
  }
  return result;
}

}  // namespace volute
