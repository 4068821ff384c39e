// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstddef>

namespace volute {

/// A box of voxels, [begin, end) on each axis, in the order x, y, z.
struct Region {
  std::array<int, 3> begin{};
  std::array<int, 3> end{};

  int x() const { return end[0] - begin[0]; }

  int y() const { return end[1] - begin[1]; }

  int z() const { return end[2] - begin[2]; }

  std::size_t voxels() const { return static_cast<std::size_t>(x()) * y() * z(); }

  bool operator==(const Region&) const = default;
};

}  // namespace volute
