// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/synth/puffs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

#include "volute/base/parallel.hpp"
#include "volute/grid/bricks.hpp"
#include "volute/synth/noise.hpp"

namespace volute {
namespace {

constexpr int kPuffs = 12;
constexpr float kReach = 1.3F;        // of the radius
constexpr float kFaintest = 0.02F;    // what is below is empty
constexpr double kMetres = 2;         // of the cube's side
constexpr double kLeavesShare = .03;  // of all, at most

/// One of them at a time, in a cube of side 1.
struct Puff {
  std::uint32_t seed = 0;
  float radius = 0, strength = 0, rise = 0;
  std::array<float, 3> centre{};

  Puff(std::uint32_t all, int number, int frame)
      : seed(mix(mix(all) + static_cast<std::uint32_t>(number))) {
    const auto random = [&](std::uint32_t key) {
      return static_cast<float>(mix(seed ^ (key + 1)) >> 8) * 0x1p-24F;
    };
    radius = 0.035F + 0.04F * random(0);
    strength = 0.6F + random(1);
    rise = 0.004F * static_cast<float>(frame);
    centre = {0.12F + 0.76F * random(2) + rise * (random(3) - 0.5F),
              0.12F + 0.76F * random(4) + rise * (random(5) - 0.5F),
              0.12F + 0.7F * random(6) + rise};
  }

  float node(int x, int y, int z) const {
    const std::uint32_t key = static_cast<std::uint32_t>(x) * 73856093U ^
                              static_cast<std::uint32_t>(y) * 19349663U ^
                              static_cast<std::uint32_t>(z) * 83492791U;
    return static_cast<float>(mix(seed ^ key) >> 8) * 0x1p-24F;
  }

  /// Smooth between random numbers of the nodes of a lattice, 0..1.
  float noise(const std::array<float, 3>& p) const {
    int cell[3];
    float share[3];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float low = std::floor(p[axis]), t = p[axis] - low;
      cell[axis] = static_cast<int>(low), share[axis] = t * t * (3 - 2 * t);
    }
    float line[4];
    for (int i = 0; i < 4; ++i) {
      const int y = cell[1] + (i & 1), z = cell[2] + (i >> 1);
      const float from = node(cell[0], y, z);
      line[i] = from + share[0] * (node(cell[0] + 1, y, z) - from);
    }
    const float low = line[0] + share[1] * (line[1] - line[0]),
                high = line[2] + share[1] * (line[3] - line[2]);
    return low + share[2] * (high - low);
  }

  float density(const std::array<float, 3>& at) const {
    std::array<float, 3> from;
    for (std::size_t axis = 0; axis < 3; ++axis) from[axis] = at[axis] - centre[axis];
    const float far = std::sqrt(from[0] * from[0] + from[1] * from[1] + from[2] * from[2]);
    const float core = 1.1F - far / radius;
    if (core < -0.3F)
      return 0;
    float sum = 0, weight = 0.5F, frequency = 2.2F / radius;
    for (int octave = 0; octave < 6; ++octave, weight *= 0.55F, frequency *= 2.03F) {
      const float along = 3.1F * static_cast<float>(octave);
      sum += weight * noise({from[0] * frequency + along, from[1] * frequency,
                             from[2] * frequency + along + 5 * rise / radius});
    }
    const float value = std::min(2.0F, strength * (core + 1.6F * (sum - 0.55F)));
    return value > kFaintest ? value : 0;
  }
};

}  // namespace

PuffSource::PuffSource(const PuffOptions& options) : seed_(options.seed) {
  info_.name = "density";
  info_.unit = "1/m";
  info_.frames = options.frames;
  info_.x = info_.y = info_.z = options.size;
  info_.bounds = {Vec3(-1, -1, 0), Vec3(1, 1, kMetres)};
  info_.fillDefaults();
}

std::uint64_t PuffSource::brickBytes() const {
  return static_cast<std::uint64_t>(kLeavesShare * 4 * static_cast<double>(info_.frameValues()));
}

Status PuffSource::readFrame(int index, std::span<float> values) {
  Bricks bricks;
  VOLUTE_TRY(FrameSource::readBricks(index, bricks));
  bricks.toDense({{0, 0, 0}, {info_.x, info_.y, info_.z}}, values);
  return {};
}

Status PuffSource::readBricks(int index, int first, int end, Bricks& bricks) {
  const auto perVoxel = 1 / static_cast<float>(info_.x);
  std::vector<Puff> puffs;
  std::map<VoxelIndex, std::vector<int>> near;  // which puffs may reach a leaf
  for (int number = 0; number < kPuffs; ++number) {
    const Puff& puff = puffs.emplace_back(seed_, number, index);
    const auto leaf = [&](std::size_t axis, float way) {
      const float voxel = (puff.centre[axis] + way * kReach * puff.radius) / perVoxel;
      return static_cast<int>(std::clamp(voxel, 0.0F, static_cast<float>(info_.x - 1))) / 8 * 8;
    };
    for (int z = std::max(leaf(2, -1), first / 8 * 8); z <= leaf(2, 1) && z < end; z += 8)
      for (int y = leaf(1, -1); y <= leaf(1, 1); y += 8)
        for (int x = leaf(0, -1); x <= leaf(0, 1); x += 8) near[{x, y, z}].push_back(number);
  }
  std::vector<std::pair<VoxelIndex, std::vector<int>>> leaves(near.begin(), near.end());
  std::vector<std::vector<float>> made(leaves.size());
  parallelRanges(leaves.size(), 4, [&](std::size_t begin, std::size_t last) {
    for (std::size_t l = begin; l < last; ++l) {
      std::vector<float> values(Bricks::kVoxels);
      bool any = false;
      for (int i = 0; i < Bricks::kVoxels; ++i) {
        const VoxelIndex& origin = leaves[l].first;
        const std::array<float, 3> at{(static_cast<float>(origin[0] + i % 8) + 0.5F) * perVoxel,
                                      (static_cast<float>(origin[1] + i / 8 % 8) + 0.5F) * perVoxel,
                                      (static_cast<float>(origin[2] + i / 64) + 0.5F) * perVoxel};
        float& value = values[static_cast<std::size_t>(i)];
        for (const int puff : leaves[l].second)
          value = std::max(value, puffs[static_cast<std::size_t>(puff)].density(at));
        any = any || value > 0;
      }
      if (any)
        made[l] = std::move(values);
    }
  });
  bricks = Bricks(1);
  for (std::size_t l = 0; l < leaves.size(); ++l) {
    if (made[l].empty())
      continue;
    Bricks::Leaf leaf{.origin = leaves[l].first};
    for (std::size_t i = 0; i < made[l].size(); ++i)
      leaf.active[i / 64] |= std::uint64_t{made[l][i] > 0} << i % 64;
    leaf.valued = leaf.active;
    std::ranges::copy(made[l], bricks.addLeaf(leaf).begin());
  }
  bricks.sort();
  return {};
}

}  // namespace volute
