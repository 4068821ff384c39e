// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstddef>
#include <vector>

namespace volute {

/// Values on two neighbouring planes of voxel centres, side by side, with zeros around them.
struct FanPlanes {
  static constexpr int kPad = 6;  ///< as far as rays reach beyond the outer values

  FanPlanes(int rowCount, int columnCount)
      : rows(rowCount),
        columns(columnCount),
        width(columnCount + 2 * kPad),
        values(2 * static_cast<std::size_t>(rowCount + 2 * kPad) * static_cast<std::size_t>(width),
               0) {}

  int rows, columns, width;
  std::vector<float> values;  ///< shape (rows + 2 kPad, width, 2)
};

/// Rays from one plane to the next, side by side on a line, in voxels: the j-th goes from (b, c + j
/// cStep) to (b + db, c + dc + j (cStep + dcStep)), over the share of the way between the planes
/// from z on.
struct FanRow {
  float b, db, c, cStep, dc, dcStep, z;
};

/// Of a number of rays, a multiple of kFanRays.
constexpr std::size_t kFanRays = 16;

/// depths[j] += scale * lengths[j] * mean, with the mean of the trilinear values on the j-th ray:
/// exact, part by part between the faces of cells.
void addFanRow(const FanPlanes& planes, const FanRow& row, std::size_t count, float scale,
               const float* lengths, float* depths);

}  // namespace volute
