// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// `volute bench fds`: opening a case of many meshes, and rays through it.
#include <sys/resource.h>

#include <cmath>
#include <filesystem>
#include <random>

#include "bench/benchmark.hpp"
#include "bench/scratch.hpp"
#include "bench/timing.hpp"
#include "volute/base/parallel.hpp"
#include "volute/fds/fds_case.hpp"

namespace volute::bench {
namespace {

constexpr int kMeshesOnSide = 10;  // 10 x 10 meshes
constexpr std::array<int, 3> kCells{50, 50, 20};
constexpr double kCell = 0.1;  // [m]
constexpr int kFrames = 3;

double smokeAt(const Vec3& p, int frame) {
  return (0.2 + 0.1 * frame) *
         (1.2 + std::sin(0.7 * p.x()) * std::cos(0.9 * p.y()) * (0.5 + 0.5 * p.z()));
}

void addRecord(std::vector<std::byte>& out, const void* data, std::size_t size) {
  const auto marker = static_cast<std::int32_t>(size);
  const auto append = [&](const void* from, std::size_t bytes) {
    const auto* begin = static_cast<const std::byte*>(from);
    out.insert(out.end(), begin, begin + bytes);
  };
  append(&marker, 4);
  append(data, size);
  append(&marker, 4);
}

void addLabel(std::vector<std::byte>& out, std::string text) {
  text.resize(30, ' ');
  addRecord(out, text.data(), text.size());
}

/// A 3D slice of cells for one mesh, whose first corner is `origin`.
std::vector<std::byte> sliceBytes(const Vec3& origin) {
  std::vector<std::byte> out;
  addLabel(out, "SOOT EXTINCTION COEFFICIENT");
  addLabel(out, "ext_coef_Soot");
  addLabel(out, "1/m");
  const std::array<std::int32_t, 6> at{0, kCells[0], 0, kCells[1], 0, kCells[2]};
  addRecord(out, at.data(), sizeof(at));
  for (int frame = 0; frame < kFrames; ++frame) {
    const float time = 10.0F * static_cast<float>(frame);
    addRecord(out, &time, sizeof(time));
    std::vector<float> values;
    for (int z = 0; z <= kCells[2]; ++z) {
      for (int y = 0; y <= kCells[1]; ++y) {
        for (int x = 0; x <= kCells[0]; ++x)
          values.push_back(
              static_cast<float>(smokeAt(origin + kCell * Vec3(x - 0.5, y - 0.5, z - 0.5), frame)));
      }
    }
    addRecord(out, values.data(), 4 * values.size());
  }
  return out;
}

Result<std::filesystem::path> writeCase(const std::filesystem::path& folder) {
  std::string index =
      fmt::format("FDSVERSION\nFDS6.9.1\n\nNMESHES\n {}\n\n", kMeshesOnSide * kMeshesOnSide);
  std::string files;
  for (int mesh = 0; mesh < kMeshesOnSide * kMeshesOnSide; ++mesh) {
    const Vec3 origin(kCell * kCells[0] * (mesh % kMeshesOnSide),
                      kCell * kCells[1] * (mesh / kMeshesOnSide), 0);
    index += fmt::format("GRID   mesh{}\n {} {} {}\n\n", mesh + 1, kCells[0], kCells[1], kCells[2]);
    for (int axis = 0; axis < 3; ++axis) {
      index += fmt::format("TRN{}\n 0\n", "XYZ"[axis]);
      for (int i = 0; i <= kCells[static_cast<std::size_t>(axis)]; ++i)
        index += fmt::format("{:5} {:14.5f}\n", i, origin[axis] + kCell * i);
    }
    index += "OBST\n 1\n 0 0 0 0 0 0 1 0 0 0 0 0 0\n 10 12 10 30 0 20 -1 -1\n\nVENT\n 0 0\n\n";
    const std::string name = fmt::format("bench_{}_1.sf", mesh + 1);
    files += fmt::format(
        "SLCC {} # STRUCTURED & 0 {} 0 {} 0 {}\n {}\n SOOT EXTINCTION "
        "COEFFICIENT\n ext_coef_Soot\n 1/m\n",
        mesh + 1, kCells[0], kCells[1], kCells[2], name);
    VOLUTE_TRY(writeScratch(folder / name, sliceBytes(origin)));
  }
  index += files;
  VOLUTE_TRY(writeScratch(folder / "bench.smv", std::as_bytes(std::span(index))));
  return folder / "bench.smv";
}

std::vector<Segment> sightLines(const Box3& bounds, std::size_t count) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> share(0, 1);
  std::vector<Segment> lines;
  while (lines.size() < count) {
    const auto point = [&] {
      return Vec3(bounds.min +
                  Vec3(share(random), share(random), share(random)).cwiseProduct(bounds.size()));
    };
    const Vec3 eye = point();
    const Vec3 target = point();
    const double length = (target - eye).norm();
    if (length > 1 && length < 30)
      lines.push_back({eye, (target - eye) / length, 0, length});
  }
  return lines;
}

/// The walk that one writes down first: all crossings of all planes on the way, sorted, and the
/// cell in the middle of each stretch looked up. Scalar, one mesh size.
double plainDepth(const FdsField& field, const Segment& line) {
  std::vector<double> cuts{line.begin, line.end};
  const Box3 bounds = field.bounds();
  for (int axis = 0; axis < 3; ++axis) {
    const int planes = static_cast<int>(std::lround(bounds.size()[axis] / kCell));
    for (int i = 0; i <= planes; ++i) {
      const double s = (bounds.min[axis] + kCell * i - line.origin[axis]) / line.direction[axis];
      if (s > line.begin && s < line.end)
        cuts.push_back(s);
    }
  }
  std::sort(cuts.begin(), cuts.end());
  double sum = 0;
  for (std::size_t i = 0; i + 1 < cuts.size(); ++i)
    sum += field.extinction(line.at(0.5 * (cuts[i] + cuts[i + 1]))) * (cuts[i + 1] - cuts[i]);
  return sum;
}

double peakMegabytes() {
  struct rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

void addRays(BenchRows& rows, const FdsField& field) {
  const auto lines = sightLines(field.bounds(), 20000);
  const std::span<const Segment> some(lines.data(), 500);
  std::vector<double> plain(some.size());
  const double plainSeconds = medianSeconds([&] {
    for (std::size_t i = 0; i < some.size(); ++i) plain[i] = plainDepth(field, some[i]);
  });
  const double plainRate = static_cast<double>(some.size()) / plainSeconds;
  std::vector<double> depths(lines.size());
  std::vector<FdsDepth> bands(lines.size());
  double oneCore = 0;
  double oneByOne = 0;
  {
    const ThreadLimit one(1);
    oneByOne = medianSeconds([&] { field.opticalDepthReference(lines, depths); });
    oneCore = medianSeconds([&] { field.opticalDepth(lines, depths); });
  }
  const double allCores = medianSeconds([&] { field.opticalDepth(lines, depths); });
  const double banded = medianSeconds([&] { field.depths(lines, bands); });
  double worst = 0;
  for (std::size_t i = 0; i < some.size(); ++i)
    worst = std::max(worst, std::abs(depths[i] - plain[i]) / (1 + plain[i]));
  const auto rate = [&](double seconds) { return static_cast<double>(lines.size()) / seconds; };
  rows.add({"rays, plain loop, one core", plainRate, "rays/s", 1.0, {}, "the baseline"});
  rows.add({"rays, one core, one at a time",
            rate(oneByOne),
            "rays/s",
            rate(oneByOne) / plainRate,
            {},
            {}});
  rows.add({"rays, one core", rate(oneCore), "rays/s", rate(oneCore) / plainRate, {}, {}});
  rows.add({"rays, all cores", rate(allCores), "rays/s", rate(allCores) / plainRate, {}, {}});
  rows.add({"rays with bounds and cover, all cores",
            rate(banded),
            "rays/s",
            rate(banded) / plainRate,
            {},
            {}});
  rows.add({"largest relative difference", worst, "", std::nullopt, {}, {}});
}

}  // namespace

Status benchFds(const BenchInput& input, BenchRows& rows, Progress& progress) {
  VOLUTE_ASSIGN(const auto folder, ScratchFolder::create());
  std::filesystem::path path = input.volume;
  const bool made = path.extension() != ".smv";
  if (made) {
    progress.report("writing the case", 0, 1);
    VOLUTE_ASSIGN(path, writeCase(folder.path()));
  }
  FdsOptions options;
  options.maxMemory = input.maxMemory;
  const auto begin = Clock::now();
  VOLUTE_ASSIGN(auto opened, FdsCase::open(path, options));
  const auto indexed = Clock::now();
  VOLUTE_ASSIGN(const FdsField field, opened.field(opened.times().front()));
  const auto read = Clock::now();
  std::uint64_t cells = 0;
  for (const FdsMesh& mesh : opened.index().meshes) cells += mesh.cellCount();
  const auto seconds = [](auto a, auto b) { return std::chrono::duration<double>(b - a).count(); };
  rows.add({"open",
            seconds(begin, indexed),
            "s",
            std::nullopt,
            {},
            fmt::format("{} meshes, {} cells", opened.index().meshes.size(), cells)});
  rows.add({"first frame", seconds(indexed, read), "s", std::nullopt, {}, {}});
  rows.add({"peak memory", peakMegabytes(), "MiB", std::nullopt, {}, "of the whole program"});
  if (made)
    addRays(rows, field);
  return {};
}

}  // namespace volute::bench
