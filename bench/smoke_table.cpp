// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "bench/smoke_table.hpp"

#include <cmath>
#include <limits>

#include "bench/smoke_accuracy.hpp"

namespace volute::bench {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Seconds of a picture from which on a drawer that is not what the table is about draws little.
constexpr double kSlow = 1, kVerySlow = 8;

/// The baseline, and what is held against it.
bool alwaysDraws(SmokeRole role) {
  return role == SmokeRole::kBaseline || role == SmokeRole::kDepth || role == SmokeRole::kLit;
}

constexpr std::size_t kJudged = 2000;  // pixels

}  // namespace

/// The least of several frames.
struct SmokeTable::Timing {
  double wall = std::numeric_limits<double>::infinity(), cpu = wall, spent = 0;
  int frames = 0;

  void add(const DrawTimes& times) {
    wall = std::min(wall, times.wall);
    cpu = std::min(cpu, times.cpu);
    spent += times.wall;
    ++frames;
  }
};

SmokeTable::SmokeTable(const SmokeSetting& setting,
                       const std::shared_ptr<const TetLocator>& locator,
                       std::span<const std::unique_ptr<SmokeDrawer>> drawers, bool first,
                       std::vector<std::string>& stopped)
    : setting_(setting),
      locator_(locator),
      drawers_(drawers),
      first_(first),
      stopped_(stopped),
      resting_(drawers.size()) {}

BenchRow SmokeTable::rowOf(const SmokeDrawer& drawer, const char* what) const {
  BenchRow row;
  row.name = fmt::format("{}: {}, {}", setting_.name(), drawer.name(), what);
  row.value = kNone;
  row.labels = {{"case", setting_.smoke.name},
                {"eye", setting_.eye.name},
                {"size", fmt::format("{}x{}", setting_.width, setting_.height)},
                {"sign", setting_.sign ? "yes" : "no"},
                {"drawer", std::string(drawer.name())},
                {"what", what}};
  return row;
}

/// One picture of each, the first: their errors. What fails or is too slow stops here.
void SmokeTable::judge(BenchRows& rows, SmokeTargets& targets) {
  const SmokeView view = setting_.view(0, 0, 0);
  const SampledOpacity judgement(TetMedium(locator_, setting_.smoke.extinction[0]), view, kJudged);
  BenchRow reference;
  reference.name = fmt::format("{}: reference, double", setting_.name());
  reference.value = 1e3 * judgement.secondsPerPixel() * static_cast<double>(setting_.pixels());
  reference.unit = "ms";
  reference.note = fmt::format("of CPU time, from {} pixels", judgement.pixels());
  rows.add(std::move(reference));
  std::vector<float> opacity(setting_.pixels());
  for (std::size_t i = 0; i < drawers_.size(); ++i) {
    if (!stopped_[i].empty())
      continue;
    const SmokeRole role = drawers_[i]->role();
    BenchRow row = rowOf(*drawers_[i], "largest error of opacity");
    const auto times = drawers_[i]->draw(view, opacity);
    if (!times) {
      row.note = stopped_[i] = times.error().message;
    } else {
      const auto [worst, off] = judgement.errors(opacity);
      row.value = worst;
      row.note = fmt::format("{:.2f} % of the pixels off by more than 1/255", 100 * off);
      targets.addError(role, setting_, worst);
      const std::string taken = fmt::format("a picture takes {:.1f} s", times->wall);
      if (role == SmokeRole::kOther && times->wall > kVerySlow)
        stopped_[i] = taken + "; no more were drawn";
      else if (!alwaysDraws(role) && times->wall > kSlow && !first_)
        resting_[i] = taken + "; the modes were drawn in the eye's first table alone";
    }
    rows.add(std::move(row));
  }
}

std::vector<SmokeTable::Timing> SmokeTable::draw(const SmokeMode& mode) {
  constexpr int kMax = 6;
  constexpr double kPatience = 1.5;  // seconds, after the least number of frames
  const auto least = [&](std::size_t i) { return alwaysDraws(drawers_[i]->role()) ? 2 : 1; };
  std::vector<Timing> timings(drawers_.size());
  std::vector<float> opacity(setting_.pixels());
  for (int frame = 1; frame <= kMax; ++frame) {
    const auto fields = static_cast<int>(setting_.smoke.extinction.size());
    const SmokeView view =
        setting_.view(mode.newSmoke ? frame % fields : 0, frame, mode.moving ? frame : 0);
    for (std::size_t i = 0; i < drawers_.size(); ++i) {
      const bool enough = frame > least(i) && timings[i].spent > kPatience;
      if (enough || !stopped_[i].empty() || !resting_[i].empty())
        continue;
      const auto times = drawers_[i]->draw(view, opacity);
      if (times)
        timings[i].add(*times);
      else
        stopped_[i] = times.error().message;
    }
  }
  return timings;
}

Status SmokeTable::measure(BenchRows& rows, SmokeTargets& targets, Progress& progress) {
  judge(rows, targets);
  for (const SmokeMode& mode : kSmokeModes) {
    if (progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped in {}", setting_.name());
    const std::vector<Timing> timings = draw(mode);
    const Timing& baseline = timings.front();
    for (std::size_t i = 0; i < drawers_.size(); ++i) {
      const SmokeRole role = drawers_[i]->role();
      BenchRow row = rowOf(*drawers_[i], mode.name);
      row.unit = "ms";
      row.note = stopped_[i].empty() ? resting_[i] : stopped_[i];
      if (timings[i].frames > 0) {
        row.value = 1e3 * timings[i].wall;
        row.note += fmt::format("{}{:.0f} ms of CPU time, {} frames", row.note.empty() ? "" : "; ",
                                1e3 * timings[i].cpu, timings[i].frames);
        targets.addSeconds(role, setting_, timings[i].wall);
      }
      if (timings[i].frames > 0 && baseline.frames > 0) {
        row.ratio = baseline.wall / timings[i].wall;
        targets.addRatio(role, mode, setting_, *row.ratio);
      }
      rows.add(std::move(row));
    }
  }
  return {};
}

}  // namespace volute::bench
