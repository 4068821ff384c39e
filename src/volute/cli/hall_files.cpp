// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/hall_files.hpp"

#include <vector>

#include "volute/io/vtu_writer.hpp"
#include "volute/tetmesh/hall_smoke.hpp"
#include "volute/tetmesh/made_meshes.hpp"

namespace volute::cli {

Status writeHall(const HallFiles& files, const std::filesystem::path& target, Progress& progress) {
  if (target.extension() != ".pvd") {
    return fail(ErrorCode::kInvalidArgument, "--output: '{}' is no .pvd series of meshes",
                target.string());
  }
  const auto mesh = hallMesh(files.cell, files.seed);
  std::vector<SeriesFile> series;
  for (int i = 0; i < files.steps; ++i) {
    if (progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped before step {}", i);
    const double time = i * files.interval;
    series.push_back({fmt::format("{}_{:04d}.vtu", target.stem().string(), i), time});
    VOLUTE_TRY(writeVtu(target.parent_path() / series.back().name, *mesh, "soot",
                        hallSmoke(*mesh, time, files.seed)));
    progress.report("synthesizing", i + 1, files.steps);
  }
  return writePvd(target, series);
}

}  // namespace volute::cli
