// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/grid_matrix.hpp"

#include <algorithm>
#include <cmath>

namespace volute {

Mat3 linearOf(const GridMatrix& m) {
  return {m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]};
}

Vec3 offsetOf(const GridMatrix& m) {
  return {m[3], m[7], m[11]};
}

GridMatrix gridMatrix(const Mat3& linear, const Vec3& offset) {
  GridMatrix m{};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      m[static_cast<std::size_t>(4 * row + column)] = linear(row, column);
    m[static_cast<std::size_t>(4 * row + 3)] = offset[row];
  }
  return m;
}

GridMatrix alongAxes(const std::array<double, 3>& voxelSize, const std::array<double, 3>& origin) {
  return {voxelSize[0], 0, 0, origin[0],    0,        voxelSize[1], 0,
          origin[1],    0, 0, voxelSize[2], origin[2]};
}

GridSpace spaceOf(const GridMatrix& indexToWorld) {
  const Mat3 linear = linearOf(indexToWorld);
  const Vec3 size = linear.columnNorms();
  const Mat3 turn = linear * size.cwiseInverse().asDiagonal();
  const Vec3 origin = turn.inverse() * offsetOf(indexToWorld);
  return {{size.x(), size.y(), size.z()}, {origin.x(), origin.y(), origin.z()}};
}

GridMatrix placeIn(const GridMatrix& indexToWorld, const GridSpace& space) {
  const auto& size = space.voxelSize;
  const auto& origin = space.origin;
  const Mat3 linear =
      linearOf(indexToWorld) * Vec3(size[0], size[1], size[2]).cwiseInverse().asDiagonal();
  return gridMatrix(linear,
                    offsetOf(indexToWorld) - linear * Vec3(origin[0], origin[1], origin[2]));
}

bool isSound(const GridMatrix& matrix) {
  if (!std::ranges::all_of(matrix, [](double number) { return std::isfinite(number); }))
    return false;
  const Mat3 linear = linearOf(matrix);
  const Vec3 size = linear.columnNorms();
  return size.minCoeff() > 0 && std::isfinite(size.maxCoeff()) &&
         std::abs((linear * size.cwiseInverse().asDiagonal()).determinant()) > 1e-9;
}

Box3 aroundPlaces(const Box3& box, std::span<const GridMatrix> places) {
  if (places.empty())
    return box;
  Box3 around;
  for (const GridMatrix& place : places) {
    for (int corner = 0; corner < 8; ++corner)
      around.extend(linearOf(place) * box.corner(corner) + offsetOf(place));
  }
  return around;
}

bool samePlaces(std::span<const GridMatrix> a, std::span<const GridMatrix> b, const Box3& box,
                double voxel) {
  if (a.size() != b.size())
    return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Mat3 linear = linearOf(a[i]) - linearOf(b[i]);
    const Vec3 offset = offsetOf(a[i]) - offsetOf(b[i]);
    for (int corner = 0; corner < 8; ++corner) {
      if (!((linear * box.corner(corner) + offset).norm() <= 1e-3 * voxel))
        return false;
    }
  }
  return true;
}

}  // namespace volute
