// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// `volute bench visibility`: maps of a plan, against a loop over rays in NumPy.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "bench/benchmark.hpp"
#include "bench/scratch.hpp"
#include "bench/timing.hpp"
#include "volute/media/fds/fds_sight.hpp"
#include "volute/visibility/survey.hpp"

namespace volute::bench {
namespace {

constexpr int kNx = 200, kNy = 100, kTimes = 21;
constexpr double kMapCell = 0.1;      // [m]
constexpr double kSliceHeight = 2.0;  // [m], of the slice

/// A floor of 20 x 10 m with walls, seen at the height of one slice; smoke spreads from a fire.
struct Floor {
  std::vector<std::vector<float>> extinction;  ///< of each time, (y, x)
  std::vector<unsigned char> solid;
  SmvIndex index;  ///< its obstructions
};

bool isWall(int x, int y) {
  const bool across = (x >= 60 && x < 62 && y < 70) || (x >= 130 && x < 132 && y >= 30);
  return across || (y >= 50 && y < 52 && x >= 80 && x < 120);
}

FdsObstruction wall(int x0, int x1, int y0, int y1) {
  FdsObstruction obstruction;
  obstruction.nodes = {{x0, y0, 0}, {x1, y1, 1}};
  return obstruction;
}

Floor makeFloor() {
  Floor floor;
  for (int t = 0; t < kTimes; ++t) {
    auto& values = floor.extinction.emplace_back();
    for (int y = 0; y < kNy; ++y) {
      for (int x = 0; x < kNx; ++x) {
        const double distance = std::hypot(x - 40.0, y - 80.0) * kMapCell;
        const double front = 1 / (1 + std::exp(distance - t));
        const double eddies = 1 + 0.4 * std::sin(0.31 * x + 0.2 * t) * std::cos(0.23 * y);
        values.push_back(isWall(x, y) ? 0 : static_cast<float>(0.6 * front * eddies));
      }
    }
  }
  for (int y = 0; y < kNy; ++y) {
    for (int x = 0; x < kNx; ++x) floor.solid.push_back(isWall(x, y) ? 1 : 0);
  }
  FdsMesh mesh;
  for (int i = 0; i <= kNx; ++i) mesh.planes[0].push_back(i * kMapCell);
  for (int i = 0; i <= kNy; ++i) mesh.planes[1].push_back(i * kMapCell);
  mesh.planes[2] = {kSliceHeight - 0.05, kSliceHeight + 0.05};
  mesh.obstructions = {wall(60, 62, 0, 70), wall(130, 132, 30, kNy), wall(80, 120, 50, 52)};
  floor.index.meshes.push_back(std::move(mesh));
  return floor;
}

/// @param bounded  as files of bytes are read: each value with what it may be at least and at most
Result<std::vector<FdsSightSnapshot>> snapshotsOf(const Floor& floor, bool bounded) {
  FdsLattice lattice;
  lattice.planes = floor.index.meshes[0].planes;
  VOLUTE_ASSIGN(const auto grid, FdsGrid::create({lattice}));
  auto cells = std::make_shared<std::vector<FdsCell>>();
  for (const unsigned char solid : floor.solid)
    cells->push_back(solid != 0 ? FdsCell::kSolid : FdsCell::kGas);
  std::vector<FdsSightSnapshot> snapshots;
  for (const auto& extinction : floor.extinction) {
    auto values = std::make_shared<FdsValues>();
    values->value = extinction;
    for (const float value : extinction) {
      if (!bounded)
        break;
      values->low.push_back(0.9F * value);
      values->high.push_back(1.1F * value + 0.01F);
    }
    snapshots.emplace_back(FdsField(grid, {values}, {cells}), FdsObstructions(floor.index, 0), 1);
  }
  return snapshots;
}

std::vector<SightTarget> threeSigns() {
  std::vector<SightTarget> signs;
  for (const auto& [x, y, nx, ny] :
       {std::tuple(0.05, 2.05, 1.0, 0.0), {19.95, 8.05, -1.0, 0.0}, {9.95, 0.05, 0.0, 1.0}}) {
    SafetySign sign;
    sign.name = fmt::format("sign {}", signs.size());
    sign.position = Vec3(x, y, kSliceHeight);
    sign.normal = Vec3(nx, ny, 0);
    sign.law = *visibilityLaw("jin-reflecting");
    signs.push_back({sign, sign.position});
  }
  return signs;
}

std::vector<Vec3> eyesOfPlan() {
  std::vector<Vec3> eyes;
  for (int y = 0; y < kNy; ++y) {
    for (int x = 0; x < kNx; ++x)
      eyes.emplace_back((x + 0.5) * kMapCell, (y + 0.5) * kMapCell, kSliceHeight);
  }
  return eyes;
}

/// The plain way: for each map, each ray; a sample a cell, all samples of a ray at once.
constexpr const char* kNumPy = R"(import sys, time
import numpy as np
folder, nx, ny, times, cell = sys.argv[1], int(sys.argv[2]), int(sys.argv[3]), int(sys.argv[4]), float(sys.argv[5])
smoke = np.fromfile(folder + "/smoke", dtype=np.float32).reshape(times, ny, nx)
solid = np.fromfile(folder + "/solid", dtype=np.uint8).reshape(ny, nx).astype(bool)
signs = [(0.05, 2.05, 1, 0), (19.95, 8.05, -1, 0), (9.95, 0.05, 0, 1)]
maps = np.zeros((times, len(signs), ny, nx), dtype=np.float32)
begin = time.perf_counter()
for t in range(times):
    for s, (sx, sy, normal_x, normal_y) in enumerate(signs):
        for y in range(ny):
            for x in range(nx):
                ex, ey = (x + 0.5) * cell, (y + 0.5) * cell
                dx, dy = sx - ex, sy - ey
                distance = (dx * dx + dy * dy) ** 0.5
                count = max(int(np.ceil(distance / cell)), 1)
                share = (np.arange(count) + 0.5) / count
                i = ((ex + share * dx) / cell).astype(int)
                j = ((ey + share * dy) / cell).astype(int)
                depth = smoke[t, j, i].sum() * (distance / count)
                front = -(dx * normal_x + dy * normal_y) > 0
                seen = depth <= 3 and front and not solid[j, i].any()
                maps[t, s, y, x] = depth if seen else -1
seconds = time.perf_counter() - begin
maps.tofile(folder + "/maps")
print(seconds)
)";

/// Seconds that the loop takes, or nothing where there is no NumPy.
std::optional<double> runNumPy(const ScratchFolder& scratch, int times) {
  for (const char* python : {"python3", "/usr/bin/python3"}) {
    const std::string command = fmt::format(
        "{0} -c 'import numpy' 2>/dev/null && {0} '{1}/loop.py' "
        "'{1}' {2} {3} {4} {5}",
        python, scratch.path().string(), kNx, kNy, times, kMapCell);
    std::FILE* pipe = ::popen(command.c_str(), "r");
    if (pipe == nullptr)
      continue;
    double seconds = 0;
    const bool read = std::fscanf(pipe, "%lf", &seconds) == 1;
    if (::pclose(pipe) == 0 && read)
      return seconds;
  }
  return std::nullopt;
}

/// How many of the points' answers are the same: seen or not.
Result<double> agreement(const ScratchFolder& scratch, int times,
                         std::span<const Sighting> sightings) {
  VOLUTE_ASSIGN(const auto bytes, readScratch(scratch.path() / "maps"));
  std::vector<float> maps(bytes.size() / sizeof(float));
  std::memcpy(maps.data(), bytes.data(), maps.size() * sizeof(float));
  const std::size_t count = std::size_t{3} * kNx * kNy;
  std::size_t same = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const bool seen = maps[(static_cast<std::size_t>(times) - 1) * count + i] >= 0;
    same += seen == sightings[i].visible;
  }
  return static_cast<double>(same) / static_cast<double>(count);
}

}  // namespace

Status benchVisibility(const BenchInput&, BenchRows& rows, Progress& progress) {
  const Floor floor = makeFloor();
  VOLUTE_ASSIGN(const auto snapshots, snapshotsOf(floor, false));
  VOLUTE_ASSIGN(const auto bounded, snapshotsOf(floor, true));
  const auto signs = threeSigns();
  const auto eyes = eyesOfPlan();
  std::vector<Sighting> sightings(signs.size() * eyes.size());
  // All is inside: the lines are worked out once for the 21 maps.
  const double seconds = medianSeconds([&] {
    Lookout lookout(std::uint64_t{512} << 20);
    for (const FdsSightSnapshot& snapshot : snapshots)
      lookout.look(snapshot, signs, eyes, sightings, true);
  });
  const double direct =
      medianSeconds([&] { lookAround(snapshots.back(), signs, eyes, sightings); }) * kTimes;
  const double boundedSeconds = medianSeconds([&] {
    Lookout lookout(std::uint64_t{512} << 20);
    for (const FdsSightSnapshot& snapshot : bounded)
      lookout.look(snapshot, signs, eyes, sightings, true);
  });
  const double boundedDirect =
      medianSeconds([&] { lookAround(bounded.back(), signs, eyes, sightings); }) * kTimes;
  if (progress.cancelled())
    return fail(ErrorCode::kCancelled, "stopped before the loop in NumPy");
  lookAround(snapshots.back(), signs, eyes, sightings);
  const double lines = static_cast<double>(sightings.size()) * kTimes;
  VOLUTE_ASSIGN(const auto scratch, ScratchFolder::create());
  std::vector<float> smoke;
  for (const auto& values : floor.extinction)
    smoke.insert(smoke.end(), values.begin(), values.end());
  VOLUTE_TRY(writeScratch(scratch.path() / "smoke", std::as_bytes(std::span(smoke))));
  VOLUTE_TRY(writeScratch(scratch.path() / "solid", std::as_bytes(std::span(floor.solid))));
  VOLUTE_TRY(
      writeScratch(scratch.path() / "loop.py", std::as_bytes(std::span(std::string_view(kNumPy)))));
  const auto plain = runNumPy(scratch, kTimes);
  rows.add({fmt::format("{} maps of {} x {} points, 3 signs", kTimes, kNx, kNy), seconds, "s",
            plain ? std::optional(*plain / seconds) : std::nullopt});
  rows.add({"the same, along each line anew each time", direct, "s",
            plain ? std::optional(*plain / direct) : std::nullopt});
  rows.add({.name = "smoke of bytes, with bounds",
            .value = boundedSeconds / seconds,
            .unit = "of floats' time"});
  rows.add({.name = "the same, along each line anew each time",
            .value = boundedDirect / direct,
            .unit = "of floats' time"});
  rows.add(
      {"sight lines, exact through every cell", 1e-6 * lines / seconds, "million/s", std::nullopt});
  if (!plain) {
    rows.add({.name = "the same in NumPy, a loop over rays",
              .value = std::nan(""),
              .unit = "s",
              .note = "no python3 with numpy here"});
    return {};
  }
  rows.add({"the same in NumPy, a loop over rays", *plain, "s", 1.0});
  VOLUTE_ASSIGN(const double same, agreement(scratch, kTimes, sightings));
  rows.add({"points on which both agree, last map", 100 * same, "%", std::nullopt});
  return {};
}

}  // namespace volute::bench
