// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/synth/hall_files.hpp"

#include <cmath>
#include <vector>

#include "volute/base/file_name.hpp"
#include "volute/io/vtu_writer.hpp"
#include "volute/synth/hall_case.hpp"
#include "volute/tetmesh/hall_smoke.hpp"
#include "volute/tetmesh/made_meshes.hpp"

namespace volute {

Status writeHall(const HallFiles& files, const std::filesystem::path& target, Progress& progress) {
  if (extensionOf(target) == ".smv")
    return writeHallCase(files, target, progress);
  if (extensionOf(target) != ".pvd") {
    return failFor("output", ErrorCode::kInvalidArgument,
                   "'{}' is no .pvd series of meshes, and no .smv of an FDS case", target.string());
  }
  const auto mesh = hallMesh(files.cell, files.seed);
  std::vector<SeriesFile> series;
  for (int i = 0; i < files.steps; ++i) {
    if (progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped before step {}", i);
    const double time = i * files.interval;
    series.push_back({fmt::format("{}_{:04d}.vtu", target.stem().string(), i), time});
    VOLUTE_TRY(writeVtu(target.parent_path() / series.back().name, *mesh, "soot",
                        hallSmoke(mesh->vertices(), time, files.seed)));
    progress.report("synthesizing", i + 1, files.steps);
  }
  return writePvd(target, series);
}

Status writeBall(const std::filesystem::path& target, std::uint32_t seed) {
  constexpr double kSoot = 0.5, kRadius = 0.75;  // [g/m3], [m]
  const Vec3 centre(0.2, 0.1, 1.5);
  if (extensionOf(target) != ".vtu") {
    return failFor("output", ErrorCode::kInvalidArgument, "'{}' is no .vtu file", target.string());
  }
  const auto mesh = boxMesh({Vec3(-3, -3, 0), Vec3(3, 3, 4)}, {48, 48, 32}, 0.2, seed);
  std::vector<float> soot;
  for (const Vec3& p : mesh->vertices()) {
    const double away = (p - centre).norm() / kRadius;
    soot.push_back(static_cast<float>(kSoot * std::max(0.0, 1 - std::pow(away, 4))));
  }
  return writeVtu(target, *mesh, "soot", soot);
}

}  // namespace volute
