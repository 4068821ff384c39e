// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/lattice.hpp"

#include <algorithm>

namespace volute {

bool IndexBox::contains(const IndexBox& other) const {
  if (other.empty())
    return true;
  for (int axis = 0; axis < 3; ++axis) {
    if (other.begin[axis] < begin[axis] || other.end[axis] > end[axis])
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
  for (int axis = 0; axis < 3; ++axis) {
    begin[axis] = std::min(begin[axis], other.begin[axis]);
    end[axis] = std::max(end[axis], other.end[axis]);
  }
}

IndexBox IndexBox::shifted(const std::array<std::int64_t, 3>& by) const {
  IndexBox result = *this;
  for (int axis = 0; axis < 3; ++axis) {
    result.begin[axis] += by[axis];
    result.end[axis] += by[axis];
  }
  return result;
}

}  // namespace volute
