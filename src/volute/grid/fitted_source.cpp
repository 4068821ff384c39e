// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/fitted_source.hpp"

#include <array>
#include <cmath>
#include <limits>

#include "volute/grid/resample.hpp"
#include "volute/grid/wrapped_source.hpp"

namespace volute {
namespace {

constexpr double kSamePlace = 1e-3;  // voxels

std::array<int, 3> sizeOf(const VolumeInfo& info) {
  return {info.x, info.y, info.z};
}

/// A source around which there is something else than its frames say.
class SurroundedSource final : public WrappedSource {
 public:
  SurroundedSource(std::unique_ptr<FrameSource> source, const std::array<double, 3>& outside)
      : WrappedSource(std::move(source)) {
    for (std::size_t c = 0; c < static_cast<std::size_t>(info().channels); ++c)
      outside_[c] = static_cast<float>(outside[c] - offsetOf(*source_));
  }

  Status readBricks(int index, int first, int end, Bricks& bricks) override {
    VOLUTE_TRY(source_->readBricks(index, first, end, bricks));
    if (bricks.background() == outside_)
      return {};
    // Its own background is a value like others.
    constexpr std::size_t kMaxValues = std::size_t{1} << 31;
    const VolumeInfo& own = info();
    if (own.frameValues() > kMaxValues) {
      return fail(ErrorCode::kTooLarge,
                  "'{}' has another background than what lies around it, so that all {} x {} x "
                  "{} voxels hold something; expected at most {} values",
                  own.name, own.x, own.y, own.z, kMaxValues);
    }
    std::vector<float> values(own.frameValues());
    VOLUTE_TRY(readFrame(index, values));
    bricks = Bricks::fromDense(own, values, outside_);
    return {};
  }

 private:
  std::array<float, 3> outside_{};
};

}  // namespace

bool onOneLattice(const VolumeInfo& a, const VolumeInfo& b) {
  const Vec3 size = b.voxelSize();
  const Vec3 apart = (a.bounds.min - b.bounds.min).cwiseQuotient(size);
  const Vec3 sizes = a.voxelSize().cwiseQuotient(size);
  for (int axis = 0; axis < 3; ++axis) {
    const double voxels = std::max(sizeOf(a)[static_cast<std::size_t>(axis)],
                                   sizeOf(b)[static_cast<std::size_t>(axis)]);
    if (!(std::abs(sizes[axis] - 1) * voxels < kSamePlace) ||
        !(std::abs(apart[axis] - std::round(apart[axis])) < kSamePlace))
      return false;
  }
  return true;
}

std::unique_ptr<FrameSource> fitTo(std::unique_ptr<FrameSource> source, const VolumeInfo& lattice,
                                   const std::array<double, 3>& outside) {
  auto surrounded = std::make_unique<SurroundedSource>(std::move(source), outside);
  return resampleTo(std::move(surrounded), {},
                    {indexToWorld(lattice, {}, 0), {{0, 0, 0}, {lattice.x, lattice.y, lattice.z}}},
                    Basis::kTrilinear, std::numeric_limits<std::uint64_t>::max());
}

VolumeInfo widenedTo(const VolumeInfo& info, const Box3& box) {
  VolumeInfo wide = info;
  const Vec3 size = info.voxelSize();
  int* const counts[] = {&wide.x, &wide.y, &wide.z};
  for (int axis = 0; axis < 3; ++axis) {
    const auto voxels = [&](double distance) {
      return static_cast<int>(std::clamp(std::ceil(distance / size[axis] - kSamePlace), 0.0, 1e6));
    };
    const int before = voxels(info.bounds.min[axis] - box.min[axis]);
    const int after = voxels(box.max[axis] - info.bounds.max[axis]);
    *counts[axis] += before + after;
    wide.bounds.min[axis] -= before * size[axis];
    wide.bounds.max[axis] += after * size[axis];
  }
  return wide;
}

}  // namespace volute
