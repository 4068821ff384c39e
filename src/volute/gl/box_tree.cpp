// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/box_tree.hpp"

#include <algorithm>
#include <numeric>

namespace volute {
namespace {

constexpr std::size_t kLeaf = 4;  ///< items at most

/// Rounded outwards by more than a float's rounding.
void setBox(BoxTree::Node& node, std::span<const Box3> boxes, std::span<const std::int32_t> items) {
  Box3 box;
  for (const std::int32_t item : items) box.extend(boxes[item]);
  const double margin = 1e-6 * (box.min.cwiseAbs().maxCoeff() + box.max.cwiseAbs().maxCoeff());
  for (int axis = 0; axis < 3; ++axis) {
    node.low[axis] = static_cast<float>(box.min[axis] - margin);
    node.high[axis] = static_cast<float>(box.max[axis] + margin);
  }
}

void split(BoxTree& tree, std::span<const Box3> boxes, std::size_t at, std::size_t begin,
           std::size_t end) {
  const auto items = std::span(tree.items).subspan(begin, end - begin);
  setBox(tree.nodes[at], boxes, items);
  if (items.size() <= kLeaf) {
    tree.nodes[at].first = static_cast<std::int32_t>(begin);
    tree.nodes[at].count = static_cast<std::int32_t>(items.size());
    return;
  }
  int axis = 0;
  const BoxTree::Node& node = tree.nodes[at];
  for (int i = 1; i < 3; ++i) {
    if (node.high[i] - node.low[i] > node.high[axis] - node.low[axis])
      axis = i;
  }
  const std::size_t half = items.size() / 2;
  std::ranges::nth_element(items, items.begin() + static_cast<std::ptrdiff_t>(half), {},
                           [&](std::int32_t item) { return boxes[item].centre()[axis]; });
  const std::size_t children = tree.nodes.size();
  tree.nodes[at].first = static_cast<std::int32_t>(children);
  tree.nodes.resize(children + 2);
  split(tree, boxes, children, begin, begin + half);
  split(tree, boxes, children + 1, begin + half, end);
}

}  // namespace

BoxTree::BoxTree(std::span<const Box3> boxes) : nodes(1), items(boxes.size()) {
  std::iota(items.begin(), items.end(), 0);
  if (!boxes.empty())
    split(*this, boxes, 0, 0, boxes.size());
}

}  // namespace volute
