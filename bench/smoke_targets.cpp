// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "bench/smoke_targets.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace volute::bench {

void SmokeTargets::add(const std::string& what, const char* unit, double asked, bool atLeast,
                       double found, const std::string& where) {
  auto target = std::ranges::find(targets_, what, &Target::what);
  if (target == targets_.end())
    target = targets_.insert(targets_.end(), {what, unit, asked, atLeast, found, where});
  if (!(atLeast ? found >= target->found : found <= target->found))
    target->found = found, target->where = where;
}

void SmokeTargets::addRatio(SmokeRole role, const SmokeMode& mode, const SmokeSetting& setting,
                            double ratio) {
  const std::string where = fmt::format("{}, {}", setting.name(), mode.name);
  if (role == SmokeRole::kLit)
    add("lit colour, all modes", "x VTK", 4, true, ratio, where);
  if (role != SmokeRole::kDepth)
    return;
  add("transmittance, all modes", "x VTK", 10, true, ratio, where);
  if (!mode.moving)
    add(fmt::format("transmittance, {}", mode.name), "x VTK", mode.newSmoke ? 12 : 15, true, ratio,
        where);
}

void SmokeTargets::addError(SmokeRole role, const SmokeSetting& setting, double error) {
  const std::string where = setting.name();
  if (role == SmokeRole::kDepth || role == SmokeRole::kLit)
    add("largest error of splats", "", 1e-4, false, error, where);
}

void SmokeTargets::addLight(double error, const std::string& where) {
  add("largest error of light at vertices", "", 1e-4, false, error, where);
}

void SmokeTargets::addSeconds(SmokeRole role, const SmokeSetting& setting, double seconds) {
  if (role == SmokeRole::kDepth && setting.width >= 1920)
    add("transmittance, 1920x1080", "frames/s", 2, true, 1 / seconds, setting.name());
}

void SmokeTargets::report(BenchRows& rows) const {
  for (const Target& target : targets_) {
    const bool reached =
        target.atLeast ? target.found >= target.asked : target.found <= target.asked;
    BenchRow row;
    row.name = fmt::format("worst: {}", target.what);
    row.value = target.found;
    row.unit = target.unit;
    row.labels = {{"what", "worst"}, {"of", target.what}};
    row.note = fmt::format("{} {:g} {}; {}", target.atLeast ? "at least" : "at most", target.asked,
                           reached ? "asked for" : "asked for: MISSED", target.where);
    rows.add(std::move(row));
  }
}

}  // namespace volute::bench
