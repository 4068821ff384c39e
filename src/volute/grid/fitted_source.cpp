// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/fitted_source.hpp"

#include <array>
#include <cmath>
#include <numeric>
#include <optional>

#include "volute/base/parallel.hpp"
#include "volute/grid/bricks.hpp"
#include "volute/grid/rounding_source.hpp"

namespace volute {
namespace {

constexpr double kSamePlace = 1e-3;  // voxels

std::array<int, 3> sizeOf(const VolumeInfo& info) {
  return {info.x, info.y, info.z};
}

/// What the values of a source along one axis add to a new voxel: weights of voxels from `first`
/// on.
struct AxisWeights {
  int first = 0;
  std::vector<float> weights;

  float sum() const { return std::accumulate(weights.begin(), weights.end(), 0.0F); }
};

/// Of all new voxels along an axis. The mean of samples at the middles of as many parts of the new
/// voxel as it has old ones, each linear between the centres of old voxels.
std::vector<AxisWeights> weightsAlong(int axis, const VolumeInfo& from, const VolumeInfo& to) {
  const double fromSize = from.voxelSize()[axis], toSize = to.voxelSize()[axis];
  const int parts = std::clamp(static_cast<int>(std::ceil(toSize / fromSize - kSamePlace)), 1, 64);
  const int count = sizeOf(from)[static_cast<std::size_t>(axis)];
  std::vector<AxisWeights> all;
  for (int i = 0; i < sizeOf(to)[static_cast<std::size_t>(axis)]; ++i) {
    AxisWeights one;
    const double begin = to.bounds.min[axis] + i * toSize;
    const auto centre = [&](int part) {  // in old voxels, from the centre of the first
      return (begin + (part + 0.5) * toSize / parts - from.bounds.min[axis]) / fromSize - 0.5;
    };
    one.first =
        static_cast<int>(std::clamp(std::floor(centre(0)), -1.0, static_cast<double>(count)));
    for (int part = 0; part < parts; ++part) {
      double place = centre(part);
      if (std::abs(place - std::round(place)) < kSamePlace)
        place = std::round(place);
      const double low = std::floor(place);
      for (const auto& [index, weight] :
           {std::pair(low, 1 - (place - low)), std::pair(low + 1, place - low)}) {
        if (index < 0 || index >= count || weight <= 0)
          continue;
        const auto at = static_cast<std::size_t>(static_cast<int>(index) - one.first);
        one.weights.resize(std::max(one.weights.size(), at + 1));
        one.weights[at] += static_cast<float>(weight / parts);
      }
    }
    all.push_back(std::move(one));
  }
  return all;
}

class FittedSource final : public RoundingSource {
 public:
  FittedSource(std::unique_ptr<FrameSource> source, const VolumeInfo& lattice,
               const std::array<double, 3>& outside)
      : source_(std::move(source)), info_(source_->info()), outside_(outside) {
    info_.x = lattice.x, info_.y = lattice.y, info_.z = lattice.z;
    info_.bounds = lattice.bounds;
    for (int axis = 0; axis < 3; ++axis)
      weights_[static_cast<std::size_t>(axis)] = weightsAlong(axis, source_->info(), info_);
    if (onOneLattice(source_->info(), info_)) {
      const Vec3 moved = (source_->info().bounds.min - info_.bounds.min)
                             .cwiseQuotient(source_->info().voxelSize());
      moved_.emplace();
      for (std::size_t axis = 0; axis < 3; ++axis)
        (*moved_)[axis] = std::llround(moved[static_cast<Eigen::Index>(axis)]);
    }
  }

  const VolumeInfo& info() const override { return info_; }

  std::vector<std::string> otherGrids() const override { return source_->otherGrids(); }

  /// On one lattice the same bricks elsewhere; else what is made of them.
  Status readBricks(int index, int first, int end, Bricks& bricks) override {
    if (!moved_)
      return FrameSource::readBricks(index, first, end, bricks);
    VOLUTE_TRY(source_->readBricks(index, 0, source_->info().z, bricks));
    std::array<float, 3> outside{};
    for (std::size_t c = 0; c < static_cast<std::size_t>(info_.channels); ++c)
      outside[c] = static_cast<float>(outside_[c]);
    if (bricks.background() != outside) {
      // Another background than the source has: its own is a value like others.
      constexpr std::size_t kMaxValues = std::size_t{1} << 31;
      if (info_.frameValues() > kMaxValues) {
        return fail(ErrorCode::kTooLarge,
                    "'{}' has another background than what lies around it, so that all {} x {} x "
                    "{} voxels hold something; expected at most {} values",
                    info_.name, info_.x, info_.y, info_.z, kMaxValues);
      }
      std::vector<float> values(info_.frameValues());
      VOLUTE_TRY(readFrame(index, values));
      bricks = Bricks::fromDense(info_, values, outside);
      return {};
    }
    bricks.shift(*moved_);
    bricks.crop({{0, 0, first}, {info_.x, info_.y, end}});
    return {};
  }

  bool hasTopology() const override { return moved_ && source_->hasTopology(); }

  std::uint64_t brickBytes() const override {
    return moved_ ? source_->brickBytes() : FrameSource::brickBytes();
  }

  Status readFrame(int index, std::span<float> values) override {
    const VolumeInfo& from = source_->info();
    frame_.resize(from.frameValues());
    VOLUTE_TRY(source_->readFrame(index, frame_));
    const auto channels = static_cast<std::size_t>(info_.channels);
    const auto width = static_cast<std::size_t>(info_.x);
    parallelFor(static_cast<std::size_t>(info_.z), [&](std::size_t z) {
      const AxisWeights& alongZ = weights_[2][z];
      for (std::size_t y = 0; y < static_cast<std::size_t>(info_.y); ++y) {
        const AxisWeights& alongY = weights_[1][y];
        float* out = &values[(z * static_cast<std::size_t>(info_.y) + y) * width * channels];
        std::fill_n(out, width * channels, 0.0F);
        for (std::size_t k = 0; k < alongZ.weights.size(); ++k) {
          for (std::size_t j = 0; j < alongY.weights.size(); ++j) {
            const float weight = alongZ.weights[k] * alongY.weights[j];
            if (weight == 0)
              continue;
            const auto oldZ = static_cast<std::size_t>(alongZ.first) + k;
            const auto oldY = static_cast<std::size_t>(alongY.first) + j;
            const float* row = &frame_[(oldZ * static_cast<std::size_t>(from.y) + oldY) *
                                       static_cast<std::size_t>(from.x) * channels];
            addRow(row, weight, out);
          }
        }
        if (outside_ != std::array<double, 3>{})
          addOutside(alongZ.sum() * alongY.sum(), out);
      }
    });
    return {};
  }

  double rounding() const override { return roundingOf(*source_); }

 private:
  void addRow(const float* row, float weight, float* out) const {
    const auto channels = static_cast<std::size_t>(info_.channels);
    for (std::size_t x = 0; x < weights_[0].size(); ++x) {
      const AxisWeights& alongX = weights_[0][x];
      for (std::size_t i = 0; i < alongX.weights.size(); ++i) {
        if (alongX.weights[i] == 0)
          continue;
        const float* value = row + (static_cast<std::size_t>(alongX.first) + i) * channels;
        for (std::size_t c = 0; c < channels; ++c)
          out[x * channels + c] += weight * alongX.weights[i] * value[c];
      }
    }
  }

  /// What is not of the source is of what lies outside.
  void addOutside(float share, float* out) const {
    const auto channels = static_cast<std::size_t>(info_.channels);
    for (std::size_t x = 0; x < weights_[0].size(); ++x) {
      const float rest = 1 - share * weights_[0][x].sum();
      for (std::size_t c = 0; c < channels; ++c)
        out[x * channels + c] += rest * static_cast<float>(outside_[c]);
    }
  }

  std::unique_ptr<FrameSource> source_;
  VolumeInfo info_;
  std::array<double, 3> outside_;
  std::optional<VoxelIndex> moved_;                  // of what is on one lattice
  std::array<std::vector<AxisWeights>, 3> weights_;  // along x, y, z
  std::vector<float> frame_;
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
  return std::make_unique<FittedSource>(std::move(source), lattice, outside);
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
