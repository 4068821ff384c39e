// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// `volute bench smoke`: smoke on tetrahedra, frame after frame (Staubli et al. 2005, table 3).
#include <filesystem>

#include "volute/cli/benchmarks/benchmarks.hpp"
#include "volute/cli/benchmarks/smoke_table.hpp"
#include "volute/cli/benchmarks/smoke_whole.hpp"
#include "volute/io/mesh_source.hpp"
#include "volute/tetmesh/made_meshes.hpp"

namespace volute::cli {
namespace {

/// Extinction of 1 g/m3 of the field [1/m].
constexpr float kPerGram = 0.15F;

SmokeCase madeCase(std::string name, double cell) {
  SmokeCase made{std::move(name), hallMesh(cell, 1), {}};
  for (int i = 0; i < 4; ++i) made.extinction.push_back(plume(*made.mesh, i, 1));
  return made;
}

/// The last instants of a case that have the same mesh as the last; of a single one, shares of it.
Result<SmokeCase> caseOf(const BenchInput& input) {
  const MeshOptions options{.field = "smoke", .negatives = Negatives::kClamp};
  VOLUTE_ASSIGN(auto source, MeshSource::open(input.volume, options));
  SmokeCase read{std::filesystem::path(input.volume).filename().string(), nullptr, {}};
  const std::size_t count = source.times().size();
  for (std::size_t i = count - std::min<std::size_t>(count, 4); i < count; ++i) {
    VOLUTE_ASSIGN(auto frame, source.read(i));
    if (frame.mesh != read.mesh)
      read.extinction.clear();
    read.mesh = frame.mesh;
    read.extinction.push_back(std::move(frame.values));
  }
  for (const float share : {0.97F, 0.94F, 0.91F}) {
    if (read.extinction.size() >= 4)
      break;
    auto& thinner = read.extinction.emplace_back(read.extinction.front());
    for (float& value : thinner) value *= share;
  }
  return read;
}

Status measureAll(const SmokeCase& smoke, const std::shared_ptr<const TetLocator>& locator,
                  bool quick, BenchRows& rows, SmokeTargets& targets, Progress& progress) {
  struct Size {
    int width, height;
  };

  const std::vector<Size> sizes =
      quick ? std::vector<Size>{{800, 600}} : std::vector<Size>{{800, 600}, {1920, 1080}};
  const std::vector<bool> signs = quick ? std::vector{false} : std::vector{false, true};
  const auto drawers = smokeDrawers(smoke, locator, quick);
  std::vector<std::string> stopped(drawers.size());
  for (const SmokeEye& eye : smokeEyes(*locator)) {
    bool first = true;
    for (const Size& size : sizes) {
      for (const bool sign : signs) {
        SmokeTable table({smoke, eye, size.width, size.height, sign}, locator, drawers, first,
                         stopped);
        VOLUTE_TRY(table.measure(rows, targets, progress));
        first = false;
      }
    }
  }
  return {};
}

}  // namespace

Status benchSmoke(const BenchInput& input, BenchRows& rows, Progress& progress) {
  std::vector<SmokeCase> cases;
  if (isMeshInput(input)) {
    VOLUTE_ASSIGN(cases.emplace_back(), caseOf(input));
  } else {
    cases.push_back(madeCase("made hall", 0.42));
    if (!input.quick)
      cases.push_back(madeCase("made hall, fine", 0.18));
  }
  SmokeTargets targets;
  for (SmokeCase& smoke : cases) {
    for (auto& field : smoke.extinction) {
      for (float& value : field) value *= kPerGram;
    }
    const auto locator = std::make_shared<const TetLocator>(smoke.mesh);
    rows.add({fmt::format("{}: tetrahedra", smoke.name),
              static_cast<double>(smoke.mesh->tets().size()), "", std::nullopt});
    if (input.whole)
      VOLUTE_TRY(judgeWholePictures(smoke, locator, input.quick, rows, targets, progress));
    else
      VOLUTE_TRY(measureAll(smoke, locator, input.quick, rows, targets, progress));
  }
  targets.report(rows);
  return {};
}

}  // namespace volute::cli
