// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/grid_description.hpp"

#include <algorithm>

namespace volute {

const MetadataList* FrameMetadata::at(int frame) const {
  const auto index = static_cast<std::size_t>(frame);
  if (index >= listOf.size() || listOf[index] < 0)
    return nullptr;
  return &lists[static_cast<std::size_t>(listOf[index])];
}

void FrameMetadata::add(const MetadataList* list) {
  if (!list) {
    listOf.push_back(-1);
    return;
  }
  // Mostly that of the frame before.
  const auto last =
      std::ranges::find_if(listOf.rbegin(), listOf.rend(), [](int i) { return i >= 0; });
  if (last != listOf.rend() && lists[static_cast<std::size_t>(*last)] == *list) {
    listOf.push_back(*last);
    return;
  }
  const auto same = std::ranges::find(lists, *list);
  listOf.push_back(static_cast<int>(same - lists.begin()));
  if (same == lists.end())
    lists.push_back(*list);
}

FrameMetadata FrameMetadata::of(const std::vector<int>& positions) const {
  FrameMetadata some;
  for (const int position : positions) some.add(at(position));
  return some;
}

std::vector<GridMatrix> GridDescription::places() const {
  std::vector<GridMatrix> all;
  for (const GridMatrix& matrix : matrices) all.push_back(placeIn(matrix, {voxelSize, origin}));
  return all;
}

GridDescription GridDescription::of(const std::vector<int>& positions) const {
  GridDescription some = *this;
  some.metadata = metadata.of(positions);
  some.shifts.clear();
  some.matrices.clear();
  for (const int position : positions) {
    if (!matrices.empty())
      some.matrices.push_back(matrices[static_cast<std::size_t>(position)]);
    if (!shifts.empty())
      some.shifts.push_back(shifts[static_cast<std::size_t>(position)]);
  }
  return some;
}

}  // namespace volute
