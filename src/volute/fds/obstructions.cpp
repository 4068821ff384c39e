// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/obstructions.hpp"

#include <algorithm>

#include "volute/base/parallel.hpp"

namespace volute {
namespace {

constexpr double kTouch = 1e-3;  // [m]
constexpr std::size_t kLeaf = 4;

/// Whether part of the segment between two parameters lies in the closed box. Faces count, and thin
/// boxes.
bool meets(const Box3& box, const Segment& segment, double begin, double end) {
  for (int axis = 0; axis < 3; ++axis) {
    const double origin = segment.origin[axis];
    const double direction = segment.direction[axis];
    if (direction == 0) {
      if (origin < box.min[axis] || origin > box.max[axis])
        return false;
      continue;
    }
    const double inverse = 1 / direction;
    const double a = (box.min[axis] - origin) * inverse;
    const double b = (box.max[axis] - origin) * inverse;
    begin = std::max(begin, std::min(a, b));
    end = std::min(end, std::max(a, b));
  }
  return begin <= end;
}

}  // namespace

Box3 boxOf(const FdsMesh& mesh, const FdsNodeBox& nodes) {
  Box3 box;
  for (int axis = 0; axis < 3; ++axis) {
    box.min[axis] = mesh.planes[axis][static_cast<std::size_t>(nodes.begin[axis])];
    box.max[axis] = mesh.planes[axis][static_cast<std::size_t>(nodes.end[axis])];
  }
  return box;
}

FdsColour surfaceColour(const SmvIndex& index, int surface) {
  if (surface < 0 || surface >= static_cast<int>(index.surfaces.size()))
    return FdsSurface{}.colour;
  return index.surfaces[static_cast<std::size_t>(surface)].colour;
}

FdsObstructions::FdsObstructions(const SmvIndex& index, double time)
    : boxes_(std::make_shared<std::vector<FdsBox>>()),
      nodes_(std::make_shared<std::vector<Node>>()) {
  for (const FdsMesh& mesh : index.meshes) {
    for (const FdsObstruction& one : mesh.obstructions) {
      if (!one.shownAt(time))
        continue;
      FdsBox box{boxOf(mesh, one.nodes), {}, one.drawn};
      for (std::size_t face = 0; face < 6; ++face)
        box.colours[face] = one.colour ? *one.colour : surfaceColour(index, one.surfaces[face]);
      boxes_->push_back(box);
    }
  }
  build();
}

FdsObstructions::FdsObstructions(std::vector<FdsBox> boxes)
    : boxes_(std::make_shared<std::vector<FdsBox>>(std::move(boxes))),
      nodes_(std::make_shared<std::vector<Node>>()) {
  build();
}

void FdsObstructions::build() {
  if (boxes_->empty())
    return;
  nodes_->emplace_back();
  build(0, 0, boxes_->size());
}

/// Halves the boxes along the longest axis of their centres until few are left.
void FdsObstructions::build(std::size_t node, std::size_t begin, std::size_t end) {
  Box3 bounds;
  Box3 centres;
  for (std::size_t i = begin; i < end; ++i) {
    const Box3& box = (*boxes_)[i].bounds;
    bounds.extend(box);
    centres.extend(box.centre());
  }
  (*nodes_)[node].bounds = bounds;
  if (end - begin <= kLeaf) {
    (*nodes_)[node].first = static_cast<std::int32_t>(begin);
    (*nodes_)[node].count = static_cast<std::int32_t>(end - begin);
    return;
  }
  int axis = 0;
  centres.size().maxCoeff(&axis);
  const std::size_t middle = (begin + end) / 2;
  const auto at = [&](std::size_t i) { return boxes_->begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(begin), at(middle), at(end), [&](const FdsBox& a, const FdsBox& b) {
    return a.bounds.centre()[axis] < b.bounds.centre()[axis];
  });
  const std::size_t child = nodes_->size();
  nodes_->resize(child + 2);
  (*nodes_)[node].first = static_cast<std::int32_t>(child);
  build(child, begin, middle);
  build(child + 1, middle, end);
}

bool FdsObstructions::blocked(const Segment& segment) const {
  const double begin = segment.begin + kTouch;
  const double end = segment.end - kTouch;
  if (nodes_->empty() || !(begin < end))
    return false;
  std::array<std::int32_t, 64> waiting;  // deeper than any tree of halves
  std::size_t depth = 0;
  waiting[depth++] = 0;
  while (depth > 0) {
    const Node& node = (*nodes_)[static_cast<std::size_t>(waiting[--depth])];
    if (!meets(node.bounds, segment, begin, end))
      continue;
    if (node.count == 0) {
      waiting[depth++] = node.first;
      waiting[depth++] = node.first + 1;
      continue;
    }
    for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
      if (meets((*boxes_)[static_cast<std::size_t>(i)].bounds, segment, begin, end))
        return true;
    }
  }
  return false;
}

void FdsObstructions::blocked(std::span<const Segment> segments,
                              std::span<std::uint8_t> out) const {
  parallelRanges(segments.size(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) out[i] = blocked(segments[i]) ? 1 : 0;
  });
}

std::vector<double> obstructionEvents(const SmvIndex& index) {
  std::vector<double> times;
  for (const FdsMesh& mesh : index.meshes) {
    for (const FdsObstruction& one : mesh.obstructions) {
      for (const FdsEvent& event : one.events) times.push_back(event.time);
    }
  }
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  return times;
}

}  // namespace volute
