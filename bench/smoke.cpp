// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// `volute bench smoke`: smoke on tetrahedra, frame after frame (Staubli et al. 2005, table 3).
#include "bench/benchmark.hpp"
#include "bench/smoke_accuracy.hpp"
#include "bench/smoke_table.hpp"
#include "bench/smoke_whole.hpp"

namespace volute::bench {
namespace {

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
    VOLUTE_ASSIGN(cases.emplace_back(), readSmokeCase(input));
  } else {
    cases.push_back(madeSmokeCase("made hall", 0.42));
    if (!input.quick)
      cases.push_back(madeSmokeCase("made hall, fine", 0.18));
  }
  SmokeTargets targets;
  for (const SmokeCase& smoke : cases) {
    const auto locator = std::make_shared<const TetLocator>(smoke.mesh);
    rows.add({fmt::format("{}: tetrahedra", smoke.name),
              static_cast<double>(smoke.mesh->tets().size()), "", std::nullopt});
    if (input.whole) {
      VOLUTE_TRY(judgeWholePictures(smoke, locator, input.quick, rows, targets, progress));
      continue;
    }
    VOLUTE_TRY(judgeSamples(smoke, locator, rows, targets, progress));
    VOLUTE_TRY(measureAll(smoke, locator, input.quick, rows, targets, progress));
  }
  targets.report(rows);
  return {};
}

}  // namespace volute::bench
