// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/lighting/lamp_runs.hpp"

#include <algorithm>
#include <cmath>

namespace volute {

void appendLampRuns(const TetLocator& locator, std::span<const float> extinction,
                    const Segment& way, double near, std::vector<LampRun>& runs) {
  const TetMesh& mesh = locator.mesh();
  const Box3 bounds = mesh.bounds();
  // Towards the sun a way is endless.
  const double farthest = 4 * bounds.size().maxCoeff() + (way.origin - bounds.centre()).norm();
  std::vector<TetCrossing> crossings;
  locator.crossings({way.origin, way.direction, way.begin, std::min(way.end, farthest)}, crossings);
  const std::size_t first = runs.size();
  for (const TetCrossing& crossing : crossings) {
    if (crossing.end - crossing.begin < 1e-12)
      continue;
    if (runs.size() == first || crossing.begin - runs.back().end > near)
      runs.push_back({crossing.begin, crossing.begin, 0});
    LampRun& run = runs.back();
    run.end = crossing.end;
    const auto share = mesh.shares(crossing.tet, way.at(0.5 * (crossing.begin + crossing.end)));
    for (int k = 0; k < 4; ++k) {
      run.depth += std::max(share[k], 0.0) *
                   extinction[static_cast<std::size_t>(mesh.tets()[crossing.tet][k])] *
                   (crossing.end - crossing.begin);
    }
  }
}

double lampShareOf(std::span<LampRun> runs, double end, double near) {
  std::ranges::sort(runs, [](const LampRun& a, const LampRun& b) {
    return a.begin != b.begin ? a.begin < b.begin : a.end > b.end;
  });
  double depth = 0, reached = 0;
  for (const LampRun& run : runs) {
    if (run.begin - reached > near)
      return 0;
    const double length = run.end - run.begin;
    const double covered = std::max(reached - run.begin, 0.0);
    if (length > covered)
      depth += run.depth * (covered > near ? 1 - covered / length : 1);
    reached = std::max(reached, run.end);
  }
  if (std::isfinite(end) && end - reached > near)
    return 0;
  return std::exp(-depth);
}

}  // namespace volute
