// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <memory>
#include <random>

#include "volute/grid/voxel_medium.hpp"
#include "volute/medium/conformance.hpp"

namespace volute {
namespace {

/// Some voxels of 0..1, others empty, in two bricks and a bit on each axis.
VoxelMedium voxels(int channels, Basis basis) {
  VolumeInfo info;
  info.x = 18, info.y = 17, info.z = 9;
  info.channels = channels;
  info.bounds = {Vec3(-1, 0.5, 2), Vec3(1, 2, 3)};
  info.basis = basis;
  std::mt19937 random(11);
  std::uniform_real_distribution<float> uniform(-1, 1);
  std::vector<float> values(info.frameValues());
  for (float& value : values) value = std::max(0.0F, uniform(random));
  return {std::make_shared<BrickSlice>(BrickSlice::fromDense(info, values)), 2, 0.6};
}

conformance::Traits traits(const VoxelMedium& medium) {
  conformance::Traits traits;
  const BrickSlice& slice = medium.slice();
  const std::array<int, 3> count{slice.x(), slice.y(), slice.z()};
  for (int axis = 0; axis < 3; ++axis) {
    const double voxel = slice.bounds().size()[axis] / count[axis];
    for (int i = 1; i < count[axis]; ++i) {
      traits.planes[axis].push_back(medium.bounds().min[axis] + i * voxel);
    }
  }
  if (slice.basis() == Basis::kCubic) {
    for (int axis = 0; axis < 3; ++axis) {  // cells reach one voxel further on each side
      const double voxel = slice.bounds().size()[axis] / count[axis];
      for (int i : {count[axis], count[axis] + 1, count[axis] + 2})
        traits.planes[axis].push_back(medium.bounds().min[axis] + i * voxel);
    }
  }
  // The adaptive Simpson of the suite steps over corners of voxels, which jump in the box basis.
  if (slice.basis() == Basis::kBox)
    traits.tolerance.quadrature = 5e-3;
  return traits;
}

/// What a VoxelMedium says in double: all but its fast path and its coefficients.
class InDouble {
 public:
  explicit InDouble(VoxelMedium medium) : medium_(std::move(medium)) {}

  Box3 bounds() const { return medium_.bounds(); }

  double extinction(const Vec3& point) const { return medium_.extinction(point); }

  Rgb emission(const Vec3& point) const { return medium_.emission(point); }

  void opticalDepth(std::span<const Segment> segments, std::span<double> depths) const {
    medium_.opticalDepth(segments, depths);
  }

  void pieces(std::span<const Segment> segments, std::span<std::vector<Piece>> pieces) const {
    medium_.pieces(segments, pieces);
  }

 private:
  VoxelMedium medium_;
};

conformance::MediumUnderTest inDouble(int channels, Basis basis) {
  const VoxelMedium medium = voxels(channels, basis);
  return conformance::underTest(InDouble(medium), traits(medium));
}

/// The fast path works in float, and coefficients are rounded to float.
conformance::MediumUnderTest inFloat(int channels, Basis basis) {
  const VoxelMedium medium = voxels(channels, basis);
  conformance::Traits loose = traits(medium);
  loose.tolerance.closedForm = 5e-6;
  return conformance::underTest(medium, loose);
}

VOLUTE_CONFORMANCE(BoxInDouble, inDouble(1, Basis::kBox));
VOLUTE_CONFORMANCE(BoxRgbInDouble, inDouble(3, Basis::kBox));
VOLUTE_CONFORMANCE(TrilinearInDouble, inDouble(1, Basis::kTrilinear));
VOLUTE_CONFORMANCE(TrilinearRgbInDouble, inDouble(3, Basis::kTrilinear));
VOLUTE_CONFORMANCE(CubicInDouble, inDouble(1, Basis::kCubic));
VOLUTE_CONFORMANCE(CubicRgbInDouble, inDouble(3, Basis::kCubic));
VOLUTE_CONFORMANCE(BoxInFloat, inFloat(1, Basis::kBox));
VOLUTE_CONFORMANCE(BoxRgbInFloat, inFloat(3, Basis::kBox));
VOLUTE_CONFORMANCE(TrilinearInFloat, inFloat(1, Basis::kTrilinear));
VOLUTE_CONFORMANCE(TrilinearRgbInFloat, inFloat(3, Basis::kTrilinear));
VOLUTE_CONFORMANCE(CubicInFloat, inFloat(1, Basis::kCubic));
VOLUTE_CONFORMANCE(CubicRgbInFloat, inFloat(3, Basis::kCubic));

}  // namespace
}  // namespace volute
