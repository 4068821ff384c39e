// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "volute/math/box.hpp"

namespace volute {

/// A tree of boxes as shaders walk it, halved at the median.
struct BoxTree {
  struct Node {
    float low[3] = {};
    std::int32_t first = 0;  ///< child, whose sister stands behind it, or item of a leaf
    float high[3] = {};
    std::int32_t count = 0;  ///< items of a leaf; 0: has children
  };

  std::vector<Node> nodes;          ///< at least one; boxes are rounded outwards
  std::vector<std::int32_t> items;  ///< places in `boxes`, leaf by leaf

  explicit BoxTree(std::span<const Box3> boxes);
};

}  // namespace volute
