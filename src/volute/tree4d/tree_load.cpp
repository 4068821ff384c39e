// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Tree4d::load: blocks from a .volute file.
#include <algorithm>
#include <cmath>
#include <mutex>

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
  TreeBuilder builder(info, step, static_cast<float>(header.valueMin),
                      static_cast<float>(header.valueMax));
  const BlockGrid& grid = reader.blocks();
  Status status;
  std::mutex mutex;
  const int firstRow = std::clamp(options.firstFrame / BlockGrid::kSide, 0, grid.counts()[0] - 1);
  const int endRow =
      std::clamp((std::min(options.endFrame, info.frames) - 1) / BlockGrid::kSide + 1, firstRow + 1,
                 grid.counts()[0]);
  const std::size_t first = firstRow * grid.rowCount();
  const std::size_t end = endRow * grid.rowCount();
  for (std::size_t row = first; row < end; row += grid.rowCount()) {
    if (progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped: {} of {} blocks were loaded", row - first,
                  end - first);
    parallelFor(grid.rowCount(), [&](std::size_t i) {
      std::vector<float> values(grid.values(row + i));
      Status read = reader.readBlock(row + i, values, options.levels);
      if (read) {
        builder.addBlock(row + i, values);
      } else {
        const std::lock_guard lock(mutex);
        if (status)
          status = std::move(read);
      }
    });
    VOLUTE_TRY(status);
    progress.report("loading", static_cast<double>(row + grid.rowCount() - first),
                    static_cast<double>(end - first));
  }
  return builder.finish();
}

}  // namespace volute
