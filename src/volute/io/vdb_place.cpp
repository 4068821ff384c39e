// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/vdb_place.hpp"

#include <algorithm>
#include <cmath>

#include "volute/io/vdb_file.hpp"

namespace volute {

bool isFrustum(const openvdb::GridBase& grid) {
  return !grid.transform().isLinear();
}

Status readTransform(const openvdb::GridBase& grid, const std::string& where, LatticeFrame& frame) {
  if (isFrustum(grid)) {
    return fail(ErrorCode::kUnsupported, Hint::set("resample").so("makes such voxels"),
                "{}: the grid has a frustum, which no matrix says; expected voxels of one shape",
                where);
  }
  // OpenVDB multiplies row vectors: (i, j, k, 1) * matrix.
  const openvdb::Mat4R matrix = grid.transform().baseMap()->getAffineMap()->getMat4();
  bool straight = true;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column)
      frame.matrix[static_cast<std::size_t>(4 * row + column)] = matrix(column, row);
    frame.voxelSize[static_cast<std::size_t>(row)] = matrix(row, row);
    frame.origin[static_cast<std::size_t>(row)] = matrix(3, row);
    straight = straight && matrix(row, row) > 0;
    for (int column = 0; column < 3; ++column)
      straight = straight && (row == column ||
                              std::abs(matrix(row, column)) <= 1e-9 * std::abs(matrix(row, row)));
  }
  if (!isSound(frame.matrix)) {
    return fail(ErrorCode::kInvalidData, "{}: {}", where, kBadMatrix);
  }
  frame.turned = !straight;
  if (frame.turned) {
    const GridSpace space = spaceOf(frame.matrix);
    frame.voxelSize = space.voxelSize, frame.origin = space.origin;
  }
  return {};
}

IndexBox toIndexBox(const openvdb::CoordBBox& box) {
  IndexBox result;
  if (box.empty())
    return result;
  for (int axis = 0; axis < 3; ++axis) {
    result.begin[axis] = box.min()[axis];
    result.end[axis] = std::int64_t{box.max()[axis]} + 1;
  }
  return result;
}

Status readSampledPlace(const openvdb::GridBase& grid, const openvdb::GridBase& topology,
                        const FrustumSampling& how, const std::string& where, LatticeFrame& frame) {
  GridMatrix matrix = how.indexToWorld;
  const openvdb::CoordBBox box = topology.evalActiveVoxelBoundingBox();
  if (matrix == GridMatrix{}) {
    const openvdb::Vec3d middle =
        box.empty() ? openvdb::Vec3d(0) : 0.5 * (box.min().asVec3d() + box.max().asVec3d());
    const openvdb::Vec3d size = grid.transform().voxelSize(middle);
    const double side = std::min({size[0], size[1], size[2]});
    matrix = alongAxes({side, side, side}, {0.5 * side, 0.5 * side, 0.5 * side});
  }
  if (!isSound(matrix)) {
    return fail(ErrorCode::kInvalidData, "{}: the grid's frustum is not finite, or makes it flat",
                where);
  }
  const GridSpace space = spaceOf(matrix);
  frame.matrix = matrix;
  frame.voxelSize = space.voxelSize, frame.origin = space.origin;
  frame.turned = matrix != alongAxes(space.voxelSize, space.origin);
  frame.box = FrustumLattices(grid.transform(), matrix).around(box);
  return {};
}

std::optional<IndexBox> notedBox(const openvdb::GridBase& grid) {
  const auto min = grid.getMetadata<openvdb::Vec3IMetadata>(openvdb::GridBase::META_FILE_BBOX_MIN);
  const auto max = grid.getMetadata<openvdb::Vec3IMetadata>(openvdb::GridBase::META_FILE_BBOX_MAX);
  const auto count =
      grid.getMetadata<openvdb::Int64Metadata>(openvdb::GridBase::META_FILE_VOXEL_COUNT);
  if (!min || !max || !count)
    return std::nullopt;
  const IndexBox box = toIndexBox({openvdb::Coord(min->value()), openvdb::Coord(max->value())});
  const double voxels = box.empty() ? 0 : 1.0 * box.size(0) * box.size(1) * box.size(2);
  const auto active = static_cast<double>(count->value());
  if (active < 0 || active > voxels || (active == 0) != box.empty())
    return std::nullopt;
  return box;
}

}  // namespace volute
