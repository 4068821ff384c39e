// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/math/box.hpp"
#include "volute/viewer/view_scene.hpp"

namespace volute {

/// Adds the twelve edges of a box.
inline void addBox(const Box3& box, const Rgb& color, std::vector<ViewLine>& lines) {
  for (int i = 0; i < 8; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      if (i >> axis & 1)
        continue;
      lines.push_back({box.corner(i), box.corner(i | 1 << axis), color});
    }
  }
}

}  // namespace volute
