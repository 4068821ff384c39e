// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/render_moments.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "volute/cli/picture_writer.hpp"
#include "volute/grid/select_frames.hpp"
#include "volute/io/frame_pattern.hpp"
#include "volute/scene/first_sight.hpp"

namespace volute::cli {
namespace {

/// A lone picture has a plain name, several have numbers in theirs.
Result<std::vector<Moment>> fitting(std::vector<Moment> moments, const std::string& target) {
  if (moments.size() < 2 || isFilmPath(target) || FramePattern::isPattern(target))
    return moments;
  return fail(ErrorCode::kInvalidArgument,
              "{} pictures do not fit into '{}'; put %04d for the frame's number into its name",
              moments.size(), target);
}

/// Without stored frames that count: frame n is at n / 25 s, as many as the longest medium has.
Result<std::vector<Moment>> steadyMoments(const Arguments& arguments, const Scene& scene,
                                          const std::string& target) {
  const auto chosen = arguments.find<FrameRange>("frames");
  if (!chosen && !isFilmPath(target) && !FramePattern::isPattern(target))
    return std::vector{Moment{}};
  double last = 0;
  for (const auto& medium : scene.media()) last = std::max(last, medium->info().times.back());
  const FrameRange range = chosen.value_or(FrameRange{});
  const int begin = range.begin.value_or(0);
  const int end = range.end.value_or(static_cast<int>(std::lround(last * kUsualRate)) + 1);
  std::vector<Moment> moments;
  for (int n = begin; n < end; n += range.step) moments.push_back({n, n / kUsualRate});
  if (moments.empty())
    return fail(ErrorCode::kInvalidArgument, "--frames: there is no frame from {} to {}", begin,
                end);
  return fitting(std::move(moments), target);
}

/// Pictures 25 times a second, of so many seconds each.
Result<std::vector<Moment>> momentsOfFilm(double first, double last, double speed) {
  constexpr double kMost = 1e6;
  const double count = std::round((last - first) / speed * kUsualRate) + 1;
  if (count > kMost) {
    return fail(ErrorCode::kInvalidArgument,
                "a film of {:.0f} s at --speed {:g} has {:.0f} pictures; choose a higher --speed",
                last - first, speed, count);
  }
  std::vector<Moment> moments;
  for (int i = 0; i < static_cast<int>(count); ++i)
    moments.push_back({i, std::min(first + i * speed / kUsualRate, last)});
  return moments;
}

/// The last frame lasts as long as the one before. A lone one lasts for ever.
double endOf(const MediumInfo& medium) {
  const std::size_t n = medium.times.size();
  return n < 2 || medium.loops || medium.endless ? std::numeric_limits<double>::infinity()
                                                 : 2 * medium.times[n - 1] - medium.times[n - 2];
}

/// --time must lie before the end of one medium at least, where all of them end.
Status checkTime(const Scene& scene, double time) {
  constexpr double kRounding = 1e-9;
  const MediumInfo* longest = nullptr;
  for (const auto& medium : scene.media()) {
    const MediumInfo& info = medium->info();
    if (info.endless)
      return {};
    if (info.times.size() > 1 && (!longest || endOf(info) > endOf(*longest)))
      longest = &info;
  }
  if (!longest || time <= endOf(*longest) + kRounding * (1 + std::abs(endOf(*longest))))
    return {};
  return fail(ErrorCode::kInvalidArgument,
              "--time: {:g} s is past the end: {} has {} frames from {:g} to {:g} s", time,
              longest->file, longest->times.size(), longest->times.front(), longest->times.back());
}

Result<std::vector<int>> positionsOf(const MediumInfo& medium, const FrameRange& range) {
  VolumeInfo info;
  info.frames = static_cast<int>(medium.numbers.size());
  info.frameNumbers = medium.numbers;
  auto chosen = selectPositions(info, range);
  if (chosen)
    return chosen;
  return fail(ErrorCode::kInvalidArgument, "{}: {}", medium.file, chosen.error().message);
}

/// The number of the frame that is shown at a time.
int numberAt(const MediumInfo& medium, double time) {
  const auto next = std::ranges::upper_bound(medium.times, time);
  const auto before = std::max<std::ptrdiff_t>(next - medium.times.begin() - 1, 0);
  return medium.interpolates ? 0 : medium.numbers[static_cast<std::size_t>(before)];
}

/// 25 a second, from 0 s.
std::vector<Moment> momentsUntil(double last) {
  std::vector<Moment> moments;
  const int count = static_cast<int>(std::min(std::floor(std::max(last, 0.0) * kUsualRate), 1e6)) + 1;
  for (int n = 0; n < count; ++n) moments.push_back({n, n / kUsualRate});
  return moments;
}

}  // namespace

const SceneMedium* leaderOf(const Scene& scene) {
  const SceneMedium* leader = nullptr;
  for (std::size_t i = 0; i < scene.media().size(); ++i) {
    const SceneMedium& medium = *scene.media()[i];
    if (medium.info().endless || scene.description().media[i].kind->list() != "media")
      continue;
    if (!medium.info().interpolates)
      return &medium;
    if (!leader)
      leader = &medium;
  }
  return leader;
}

namespace {

Result<std::vector<Moment>> momentsInTime(const Arguments& arguments, Scene& scene,
                                          const std::string& target, Progress& progress) {
  const SceneMedium* leader = leaderOf(scene);
  if (const auto time = arguments.find<double>("time")) {
    VOLUTE_TRY(checkTime(scene, *time));
    return std::vector{Moment{leader ? numberAt(leader->info(), *time) : 0, *time}};
  }
  if (!leader)
    return steadyMoments(arguments, scene, target);
  // What has one frame is shown as long as the camera moves.
  const auto camera = scene.camera();
  if (leader->info().times.size() < 2 && camera && !camera->keys.empty() &&
      !arguments.given("frames") && (isFilmPath(target) || FramePattern::isPattern(target)))
    return fitting(momentsUntil(camera->keys.back().time), target);
  const MediumInfo& info = leader->info();
  const bool film = isFilmPath(target), several = film || FramePattern::isPattern(target);
  if (!arguments.given("frames") && !several) {
    if (scene.isFile())
      return std::vector{Moment{numberAt(info, 0), 0}};
    if (info.times.size() > 1) {
      VOLUTE_ASSIGN(const FirstSight first, firstSight(scene, progress));
      if (!first.reason.empty()) {
        const int number = numberAt(info, first.time);
        progress.remark(fmt::format("showing {}: {}; --time or --frames choose others",
                                    info.interpolates ? fmt::format("{:.4g} s", first.time)
                                                      : fmt::format("frame {}", number),
                                    first.reason));
        return std::vector{Moment{number, first.time}};
      }
      progress.remark(fmt::format("showing the first of {} {}; --time or --frames choose others",
                                  info.times.size(), info.interpolates ? "steps" : "frames"));
    }
    return std::vector{Moment{info.interpolates ? 0 : info.numbers.front(), info.times.front()}};
  }
  const FrameRange range = arguments.find<FrameRange>("frames").value_or(FrameRange{});
  VOLUTE_ASSIGN(const auto positions, positionsOf(info, range));
  if (film && info.interpolates && range.step > 1) {
    return fail(ErrorCode::kInvalidArgument,
                "--frames: a film of {} has 25 pictures a second between the first and the last "
                "chosen frame, whatever the step ({}); leave it out, or write stills",
                info.kind, range.step);
  }
  const auto at = [&](int position) { return static_cast<std::size_t>(position); };
  if (film && info.interpolates) {
    return momentsOfFilm(info.times[at(positions.front())], info.times[at(positions.back())],
                         arguments.get<double>("speed"));
  }
  std::vector<Moment> moments;
  for (const int position : positions)
    moments.push_back({info.numbers[at(position)], info.times[at(position)]});
  return fitting(std::move(moments), target);
}

}  // namespace

Result<std::vector<Moment>> momentsOf(const Arguments& arguments, Scene& scene,
                                      const std::string& target, Progress& progress) {
  VOLUTE_ASSIGN(auto moments, momentsInTime(arguments, scene, target, progress));
  const auto orbit = arguments.find<double>("orbit");
  if (!orbit)
    return moments;
  if (!isFilmPath(target) && !FramePattern::isPattern(target)) {
    return fail(ErrorCode::kInvalidArgument,
                "--orbit: a single picture shows no turn; write a film, or put %04d into the name");
  }
  if (moments.size() == 1) {
    constexpr double kSecondsOfATurn = 10;
    const double count = std::round(std::abs(*orbit) / 360 * kSecondsOfATurn * kUsualRate);
    moments.assign(static_cast<std::size_t>(std::clamp(count, 2.0, 1e6)), moments.front());
    for (std::size_t i = 0; i < moments.size(); ++i) moments[i].number = static_cast<int>(i);
  }
  // The last picture is a step before the first one again.
  for (std::size_t i = 0; i < moments.size(); ++i)
    moments[i].turn = static_cast<double>(i) / static_cast<double>(moments.size());
  return moments;
}

double framesPerSecond(const Scene& scene, const std::vector<Moment>& moments) {
  const SceneMedium* leader = leaderOf(scene);
  if (moments.size() < 2 || (leader && leader->info().interpolates) ||
      !(moments.back().time > moments.front().time))
    return kUsualRate;
  return static_cast<double>(moments.size() - 1) / (moments.back().time - moments.front().time);
}

}  // namespace volute::cli
