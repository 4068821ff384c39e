// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/volume/volume_motion.hpp"

#include <algorithm>
#include <cmath>

#include "volute/base/parallel.hpp"

namespace volute {
namespace {

constexpr int kIterations = 4;  ///< of a path's end: velocities change slowly from voxel to voxel
using VoxelPlace = std::array<float, 3>;

/// Values of a frame between the centres of voxels; 0 outside.
class Between {
 public:
  Between(const VolumeInfo& info, int channels, std::span<const float> values)
      : size_{info.x, info.y, info.z}, channels_(channels), values_(values) {}

  /// @param at  [voxels], 0 at the centre of the first
  void read(const VoxelPlace& at, float* out) const {
    int first[3];
    float share[3];
    std::fill_n(out, channels_, 0.0F);
    for (int axis = 0; axis < 3; ++axis) {
      if (!(at[axis] > -1 && at[axis] < static_cast<float>(size_[axis])))
        return;
      const float low = std::floor(at[axis]);
      first[axis] = static_cast<int>(low), share[axis] = at[axis] - low;
    }
    for (int corner = 0; corner < 8; ++corner) {
      float weight = 1;
      std::ptrdiff_t index = 0;
      bool inside = true;
      for (int axis = 2; axis >= 0; --axis) {
        const int side = corner >> axis & 1, place = first[axis] + side;
        weight *= side ? share[axis] : 1 - share[axis];
        inside = inside && place >= 0 && place < size_[axis];
        index = index * size_[axis] + place;
      }
      if (!inside || weight == 0)
        continue;
      for (int c = 0; c < channels_; ++c) out[c] += weight * values_[index * channels_ + c];
    }
  }

 private:
  int size_[3];
  int channels_;
  std::span<const float> values_;
};

template <class Body>
void forVoxels(const VolumeInfo& info, Body&& body) {
  const std::size_t rows = static_cast<std::size_t>(info.z) * info.y;
  parallelRanges(rows, 8, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row) {
      for (int x = 0; x < info.x; ++x) {
        body(row * info.x + x, VoxelPlace{static_cast<float>(x), static_cast<float>(row % info.y),
                                          static_cast<float>(row / info.y)});
      }
    }
  });
}

VoxelPlace sum(const VoxelPlace& a, const VoxelPlace& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

}  // namespace

VoxelPaths pathsBetween(const VolumeInfo& info, std::span<const float> before,
                        std::span<const float> after, const Vec3& step, double share) {
  VoxelPaths paths;
  paths.from.resize(info.voxels()), paths.to.resize(info.voxels());
  const Between early(info, 3, before), late(info, 3, after);
  VoxelPlace back, ahead;
  for (int axis = 0; axis < 3; ++axis) {
    back[axis] = static_cast<float>(-share * step[axis]);
    ahead[axis] = static_cast<float>((1 - share) * step[axis]);
  }
  forVoxels(info, [&](std::size_t voxel, const VoxelPlace& place) {
    const float *a = &before[3 * voxel], *b = &after[3 * voxel];
    const auto speed = [](const float* v) { return v[0] * v[0] + v[1] * v[1] + v[2] * v[2]; };
    const float* first = speed(a) >= speed(b) ? a : b;  // what moves may not have come yet
    const auto follow = [&](const Between& velocity, const VoxelPlace& times) {
      VoxelPlace way{times[0] * first[0], times[1] * first[1], times[2] * first[2]};
      for (int i = 0; i < kIterations; ++i) {
        float v[3];
        velocity.read(sum(place, way), v);
        way = {times[0] * v[0], times[1] * v[1], times[2] * v[2]};
      }
      return way;
    };
    paths.from[voxel] = follow(early, back);
    paths.to[voxel] = follow(late, ahead);
  });
  return paths;
}

void blendFrames(const VolumeInfo& info, std::span<const float> before,
                 std::span<const float> after, double share, const VoxelPaths* paths,
                 std::span<float> out) {
  const auto late = static_cast<float>(share), early = 1 - late;
  if (!paths) {
    parallelRanges(out.size(), 1 << 14, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) out[i] = early * before[i] + late * after[i];
    });
    return;
  }
  const int channels = info.channels;
  const Between a(info, channels, before), b(info, channels, after);
  forVoxels(info, [&](std::size_t voxel, const VoxelPlace& place) {
    float from[3], to[3];
    a.read(sum(place, paths->from[voxel]), from);
    b.read(sum(place, paths->to[voxel]), to);
    for (int c = 0; c < channels; ++c) out[voxel * channels + c] = early * from[c] + late * to[c];
  });
}

}  // namespace volute
