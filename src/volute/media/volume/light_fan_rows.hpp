// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
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

/// A share of one value beside a ray on its way between two planes.
struct FanTap {
  int plane;  ///< 1: the one that is nearer to the light
  int b, c;
  float share;
};

/// All of a step between planes.
struct FanTaps {
  static constexpr std::size_t kMax = 50;  ///< 5 x 5 on each plane

  void add(const FanTap& tap) {
    taps[count++] = tap;
    minB = std::min(minB, tap.b), maxB = std::max(maxB, tap.b);
    maxC = std::max(maxC, tap.c);
  }

  std::array<FanTap, kMax> taps;
  std::size_t count = 0;
  int minB = 2, maxB = -2, maxC = -2;
};

/// A brick's 8 x 8 values on two planes, zeros around them.
struct FanBrick {
  static constexpr int kSide = 8, kPad = 4, kLanes = 16, kWidth = kLanes + 2 * kPad;
  static constexpr int kPlane = (kSide + 2 * kPad) * kWidth;

  /// Those of one plane; of a plane that is not in the brick zeros.
  /// @param values  of a brick, 8^3
  void take(int side, const float* values, std::size_t axis, int plane) {
    constexpr int kStride[3] = {1, kSide, kSide * kSide};
    const int row = kStride[axis == 2 ? 1 : 2], column = kStride[axis == 0 ? 1 : 0];
    float* to = planes.data() + side * kPlane + kPad * kWidth + kPad;
    if (plane < 0 || plane >= kSide) {
      for (int b = 0; b < kSide; ++b) std::fill_n(to + b * kWidth, kSide, 0.0F);
      return;
    }
    values += plane * kStride[axis];
    for (int b = 0; b < kSide; ++b) {
      for (int c = 0; c < kSide; ++c) to[b * kWidth + c] = values[b * row + c * column];
    }
  }

  std::array<float, 2 * kPlane> planes{};
};

/// Adds what a brick gives to rays in rows of `width`.
/// @param ray  the one of the brick's first value
void addFanBrick(const FanBrick& brick, const FanTaps& taps, float* ray, std::size_t width);

}  // namespace volute
