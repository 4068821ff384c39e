// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace volute {

/// Samples on a regular lattice of x * y * z points, x fastest.
struct Field {
  int x = 0, y = 0, z = 0;
  std::vector<float> values;

  Field() = default;

  Field(int sizeX, int sizeY, int sizeZ)
      : x(sizeX), y(sizeY), z(sizeZ), values(static_cast<std::size_t>(sizeX) * sizeY * sizeZ) {}

  std::size_t index(int i, int j, int k) const {
    return (static_cast<std::size_t>(k) * y + j) * x + i;
  }

  float& at(int i, int j, int k) { return values[index(i, j, k)]; }

  float at(int i, int j, int k) const { return values[index(i, j, k)]; }
};

/// The cell of eight samples around a point, and where in it the point lies (0..1 on each axis).
struct Tap {
  std::size_t base;
  std::ptrdiff_t rowStride, planeStride;
  float fx, fy, fz;

  /// A tap on `field` at lattice coordinates; points outside are moved to the border.
  Tap(const Field& field, float px, float py, float pz)
      : rowStride(field.x), planeStride(static_cast<std::ptrdiff_t>(field.x) * field.y) {
    const int i = split(px, field.x, fx);
    const int j = split(py, field.y, fy);
    const int k = split(pz, field.z, fz);
    base = field.index(i, j, k);
  }

  /// The samples in the order 000, 100, 010, 110, 001, ... (x, y, z).
  std::array<float, 8> corners(const Field& field) const {
    const float* p = field.values.data() + base;
    const float* q = p + planeStride;
    return {p[0], p[1], p[rowStride], p[rowStride + 1], q[0], q[1], q[rowStride], q[rowStride + 1]};
  }

  float interpolate(const std::array<float, 8>& c) const {
    const float x0 = c[0] + fx * (c[1] - c[0]);
    const float x1 = c[2] + fx * (c[3] - c[2]);
    const float x2 = c[4] + fx * (c[5] - c[4]);
    const float x3 = c[6] + fx * (c[7] - c[6]);
    const float y0 = x0 + fy * (x1 - x0);
    const float y1 = x2 + fy * (x3 - x2);
    return y0 + fz * (y1 - y0);
  }

 private:
  static int split(float p, int size, float& fraction) {
    p = std::clamp(p, 0.0f, static_cast<float>(size - 1));
    const int cell = std::min(static_cast<int>(p), size - 2);
    fraction = p - static_cast<float>(cell);
    return cell;
  }
};

/// Trilinear, in lattice coordinates.
inline float sample(const Field& field, float px, float py, float pz) {
  const Tap tap(field, px, py, pz);
  return tap.interpolate(tap.corners(field));
}

}  // namespace volute
