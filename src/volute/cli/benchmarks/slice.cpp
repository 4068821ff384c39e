// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/bench_timing.hpp"
#include "volute/cli/benchmarks/benchmarks.hpp"
#include "volute/grid/brick_slice.hpp"
#include "volute/grid/sequence.hpp"

namespace volute::cli {
namespace {

/// A ball that fills about an eighth of the volume: most bricks are empty, as in fire.
Sequence ball(int size) {
  Sequence sequence = makeSequence(1, size, size, size);
  const double radius = 0.31 * size;
  for (int z = 0; z < size; ++z) {
    for (int y = 0; y < size; ++y) {
      for (int x = 0; x < size; ++x) {
        const double distance = (Vec3(x, y, z) - Vec3::Constant(0.5 * size)).norm();
        if (distance < radius)
          sequence.view()(0, z, y, x, 0) = static_cast<float>(1 - distance / radius);
      }
    }
  }
  return sequence;
}

}  // namespace

Result<std::vector<BenchRow>> benchSlice(Progress& progress) {
  constexpr int kSize = 128;
  const Sequence sequence = ball(kSize);
  progress.report("slice", 1, 3);
  std::vector<float> copy(sequence.values.size());
  const double copying = medianSeconds([&] { std::ranges::copy(sequence.values, copy.begin()); });
  progress.report("slice", 2, 3);
  std::size_t bricks = 0;
  const double making = medianSeconds(
      [&] { bricks = BrickSlice::fromDense(sequence.info, sequence.values).storedBricks(); });
  progress.report("slice", 3, 3);
  const double megavoxels = static_cast<double>(sequence.values.size()) / 1e6;
  return std::vector<BenchRow>{
      {"copy a dense frame", megavoxels / copying, "Mvoxel/s", 1.0},
      {"bricks from a dense frame", megavoxels / making, "Mvoxel/s", copying / making},
      {"bricks stored", static_cast<double>(bricks), "bricks", std::nullopt},
  };
}

}  // namespace volute::cli
