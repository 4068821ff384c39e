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

Result<Tree4d> Tree4d::load(const VoluteReader& reader, Progress& progress, int levels) {
  const VolumeInfo& info = reader.info();
  const VoluteHeader& header = reader.header();
  const double range = header.valueMax - header.valueMin;
  double step = header.haarStep;
  if (!(step > 0))
    step = 0.25 * header.reachedRms * range * std::sqrt(12.0);
  if (!(step > 0))
    step = std::max(range, 1.0) * 1e-6;
  TreeBuilder builder(info, step, static_cast<float>(header.valueMin),
                      static_cast<float>(header.valueMax));
  const BlockGrid& grid = reader.blocks();
  Status status;
  std::mutex mutex;
  for (std::size_t row = 0; row < grid.count(); row += grid.rowCount()) {
    if (progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped: {} of {} blocks were loaded", row, grid.count());
    parallelFor(grid.rowCount(), [&](std::size_t i) {
      std::vector<float> values(grid.values(row + i));
      Status read = reader.readBlock(row + i, values, levels);
      if (read) {
        builder.addBlock(row + i, values);
      } else {
        const std::lock_guard lock(mutex);
        if (status)
          status = std::move(read);
      }
    });
    VOLUTE_TRY(status);
    progress.report("loading", static_cast<double>(row + grid.rowCount()),
                    static_cast<double>(grid.count()));
  }
  return builder.finish();
}

}  // namespace volute
