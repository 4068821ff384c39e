// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Tree4d::load: blocks from a .volute file.
#include <algorithm>
#include <cmath>
#include <mutex>
#include <numeric>

#include "volute/base/parallel.hpp"
#include "volute/tree4d/tree4d.hpp"
#include "volute/tree4d/tree_builder.hpp"

namespace volute {

Result<Tree4d> Tree4d::load(const VoluteReader& reader, const LoadOptions& options,
                            Progress& progress) {
  const VolumeInfo& info = reader.info();
  const VoluteHeader& header = reader.header();
  const double range = header.valueMax - header.valueMin;
  double step = 0.25 * header.reachedRms * range * std::sqrt(12.0);
  if (!(step > 0))
    step = std::max(range, 1.0) * 1e-6;
  // A block of the tree is as long as the longest of files, which may take several of those.
  const BlockGrid grid(info);
  Status status;
  std::mutex mutex;
  const int firstRow = std::clamp(options.firstFrame / BlockGrid::kSide, 0, grid.counts()[0] - 1);
  const int endRow =
      std::clamp((std::min(options.endFrame, info.frames) - 1) / BlockGrid::kSide + 1, firstRow + 1,
                 grid.counts()[0]);
  // Means, nodes' places and entries of all blocks, and a bit for each brick of a frame.
  constexpr std::uint64_t kBytesABlock = 64;
  const std::uint64_t bytes = kBytesABlock * grid.count();
  if (bytes > reader.maxMemory()) {
    return fail(ErrorCode::kTooLarge,
                "a tree over {} x {} x {} voxels needs {} MiB of memory, more than the {} MiB "
                "allowed, whatever is in them; draw its bricks",
                info.x, info.y, info.z, (bytes >> 20) + 1, reader.maxMemory() >> 20);
  }
  const std::uint64_t first = firstRow * grid.rowCount(), end = endRow * grid.rowCount();
  std::vector<std::uint64_t> blocks;
  if (reader.background() == std::array<float, 3>{}) {
    VOLUTE_ASSIGN(const auto occupied, reader.occupied());
    for (const std::uint64_t own : occupied) {
      BlockGrid::Index4 at = reader.blocks().coordinate(static_cast<std::size_t>(own));
      at[0] = grid.rowOf(at[0] * reader.blocks().frames());
      const std::uint64_t block = grid.blockAt(at);
      if (block >= first && block < end)
        blocks.push_back(block);
    }
    std::ranges::sort(blocks);
    const auto doubled = std::ranges::unique(blocks);
    blocks.erase(doubled.begin(), doubled.end());
  } else {
    blocks.resize(end - first);
    std::iota(blocks.begin(), blocks.end(), first);
  }
  if (blocks.empty())
    blocks.push_back(first);
  TreeBuilder builder(info, blocks, step, static_cast<float>(header.valueMin),
                      static_cast<float>(header.valueMax));
  constexpr std::size_t kAtOnce = 256;
  for (std::size_t done = 0; done < blocks.size(); done += kAtOnce) {
    if (progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped: {} of {} blocks were loaded", done,
                  blocks.size());
    parallelFor(std::min(kAtOnce, blocks.size() - done), [&](std::size_t i) {
      const std::uint64_t block = blocks[done + i];
      std::vector<float> values(grid.values(block));
      const BlockGrid::Index4 begin = grid.origin(block);
      BlockGrid::Index4 after = grid.extents(block);
      for (std::size_t axis = 0; axis < 4; ++axis) after[axis] += begin[axis];
      Status read = reader.readBox(begin, after, values, options.levels);
      if (read) {
        builder.addBlock(block, values);
      } else {
        const std::lock_guard lock(mutex);
        if (status)
          status = std::move(read);
      }
    });
    VOLUTE_TRY(status);
    progress.report("loading", static_cast<double>(std::min(done + kAtOnce, blocks.size())),
                    static_cast<double>(blocks.size()));
  }
  return builder.finish();
}

}  // namespace volute
