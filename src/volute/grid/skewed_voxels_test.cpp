// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include "volute/grid/brick_slice.hpp"
#include "volute/grid/grid_matrix.hpp"
#include "volute/grid/voxel_medium.hpp"
#include "volute/math/rotation.hpp"
#include "volute/medium/affine_medium.hpp"

namespace volute {
namespace {

/// Turned by 30 degrees, sheared, and stretched.
Mat3 skew() {
  Mat3 shear;
  shear = Mat3(1, .4, 0, 0, 1.5, .2, 0, 0, .7);
  return turnAbout(Vec3(1, 2, 3).normalized(), M_PI / 6) * shear;
}

VolumeInfo boxInfo(Basis basis) {
  VolumeInfo info;
  info.x = info.y = info.z = 8;
  info.frames = 1;
  info.basis = basis;
  info.bounds = {Vec3(-1, -2, 0), Vec3(1, 2, 3)};
  info.fillDefaults();
  return info;
}

AffineMedium skewed(const VolumeInfo& info, const std::vector<float>& values, const Vec3& offset) {
  auto slice = std::make_shared<const BrickSlice>(BrickSlice::fromDense(info, values));
  return {AnyMedium(VoxelMedium(std::move(slice), 0.5, 1.0)), {skew(), offset}};
}

std::vector<Segment> someSegments() {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  std::vector<Segment> segments;
  for (int i = 0; i < 200; ++i) {
    const auto vector = [&] { return Vec3(normal(random), normal(random), normal(random)); };
    segments.push_back({Vec3(2, 1, 3) + 2 * vector(), vector().normalized(), -6, 6});
  }
  return segments;
}

/// Of a box of 1 the depth is the length between its six planes, which are found in the world.
TEST(SkewedVoxels, DepthOfABlockIsItsLength) {
  const VolumeInfo info = boxInfo(Basis::kBox);
  const Vec3 offset(1, 2, 3);
  const auto medium = skewed(info, std::vector<float>(512, 1), offset);
  const auto segments = someSegments();
  std::vector<double> depths(segments.size());
  medium.opticalDepth(segments, depths);
  int hits = 0;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const Segment& segment = segments[i];
    double begin = segment.begin, end = segment.end;
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3 normal = skew().col((axis + 1) % 3).cross(skew().col((axis + 2) % 3));
      const double along = normal.dot(segment.direction);
      double near = normal.dot(skew() * info.bounds.min + offset - segment.origin) / along;
      double far = normal.dot(skew() * info.bounds.max + offset - segment.origin) / along;
      if (near > far)
        std::swap(near, far);
      begin = std::max(begin, near), end = std::min(end, far);
    }
    const double length = std::max(0.0, end - begin);
    hits += length > 0;
    EXPECT_NEAR(depths[i], length, 1e-6 * std::max(1.0, length));
  }
  EXPECT_GT(hits, 40);
}

TEST(GridMatrix, ASpaceOfItsOwnAndBack) {
  const GridMatrix matrix = gridMatrix(skew(), Vec3(4, 5, 6));
  const GridSpace space = spaceOf(matrix);
  const GridMatrix place = placeIn(matrix, space);
  const GridMatrix along = alongAxes(space.voxelSize, space.origin);
  const Vec3 index(3, -2, 7);
  EXPECT_LT((linearOf(place) * (linearOf(along) * index + offsetOf(along)) + offsetOf(place) -
             linearOf(matrix) * index - offsetOf(matrix))
                .norm(),
            1e-12);
  EXPECT_LT(offsetOf(place).norm(), 1e-12);
  EXPECT_TRUE(isSound(matrix));
  Mat3 flat = skew();
  flat.col(2) = flat.col(0);
  EXPECT_FALSE(isSound(gridMatrix(flat, Vec3::Zero())));
  EXPECT_FALSE(isSound(gridMatrix(skew(), Vec3(NAN, 0, 0))));
}

}  // namespace
}  // namespace volute
