// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/film/frame_choice.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "volute/base/plain_number.hpp"
#include "volute/film/picture_writer.hpp"
#include "volute/grid/select_frames.hpp"
#include "volute/io/frame_pattern.hpp"
#include "volute/scene/first_sight.hpp"
#include "volute/scene/scene_end.hpp"

namespace volute {
namespace {

bool takesSeveral(const std::string& target) {
  return isFilmPath(target) || namesSeries(target);
}

/// A lone picture has a plain name, several have numbers in theirs.
Result<std::vector<FilmFrame>> fitting(std::vector<FilmFrame> frames, const std::string& target) {
  if (frames.size() < 2 || takesSeveral(target))
    return frames;
  return fail(ErrorCode::kInvalidArgument,
              "{} pictures do not fit into '{}'; put %04d for the frame's number into its name",
              frames.size(), target);
}

/// Without stored frames that count: frame n is at n * speed / rate, as many as the longest medium
/// or the camera's path has.
Result<std::vector<FilmFrame>> steadyFrames(const FrameRequest& request, const Scene& scene) {
  if (!request.frames && !takesSeveral(request.target))
    return std::vector{FilmFrame{}};
  double last = std::max(request.pathEnd.value_or(0), 0.0);
  for (const auto& medium : scene.media()) last = std::max(last, medium->info().times.back());
  const double rate = request.rate / request.speed;  // a second of the scene
  const FrameRange range = request.frames.value_or(FrameRange{});
  const auto begin = static_cast<int>(std::ceil(range.begin.value_or(0)));
  const auto end = static_cast<int>(
      std::ceil(range.end.value_or(std::min(std::floor(last * rate + 1e-6) + 1, 1e6))));
  std::vector<FilmFrame> frames;
  for (int n = begin; n < end; n += range.step) frames.push_back({n, n / rate});
  if (frames.empty())
    return failFor("frames", ErrorCode::kInvalidArgument, "there is no frame from {} to {}", begin,
                   end);
  return fitting(std::move(frames), request.target);
}

/// Pictures of so many seconds each.
Result<std::vector<FilmFrame>> framesOfFilm(double first, double last,
                                            const FrameRequest& request) {
  const double speed = request.speed;
  constexpr double kMaximum = 1e6;
  const double count = std::round((last - first) / speed * request.rate) + 1;
  if (count > kMaximum) {
    return failFor("speed", ErrorCode::kInvalidArgument,
                   "a film of {:.0f} s at {:g} has {:.0f} pictures; choose a higher speed",
                   last - first, speed, count);
  }
  std::vector<FilmFrame> frames;
  for (int i = 0; i < static_cast<int>(count); ++i)
    frames.push_back({i, std::min(first + i * speed / request.rate, last)});
  return frames;
}

Result<std::vector<int>> positionsOf(const MediumInfo& medium, const FrameRange& range) {
  VolumeInfo info;
  info.frames = static_cast<int>(medium.numbers.size());
  info.frameNumbers = medium.numbers;
  info.frameScale = medium.frameScale;
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

/// For a film, in which each picture is shown as long as any other: frames that are shown until a
/// later one because some between are missing, once for each of those. Frames whose times are no
/// multiples of one interval stay as they are.
std::vector<FilmFrame> heldInGaps(std::vector<FilmFrame> frames) {
  constexpr double kUneven = 0.01;    // of an interval
  constexpr double kMostlyHeld = 10;  // pictures for each frame, all of which are drawn
  double interval = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < frames.size(); ++i)
    interval = std::min(interval, frames[i].time - frames[i - 1].time);
  if (frames.size() < 2 || !(interval > 0))
    return frames;
  const double pictures = (frames.back().time - frames.front().time) / interval;
  std::vector<FilmFrame> held;
  for (std::size_t i = 0; i + 1 < frames.size(); ++i) {
    const double times = (frames[i + 1].time - frames[i].time) / interval;
    if (std::abs(times - std::round(times)) > kUneven ||
        pictures > kMostlyHeld * static_cast<double>(frames.size()))
      return frames;
    for (int k = 0; k < static_cast<int>(std::round(times)); ++k) {
      held.push_back(frames[i]);
      held.back().time += k * interval;
    }
  }
  held.push_back(frames.back());
  return held;
}

/// Media with times of their own.
std::vector<const SceneMedium*> countedIn(const Scene& scene) {
  std::vector<const SceneMedium*> media;
  for (std::size_t i = 0; i < scene.media().size(); ++i) {
    if (!scene.media()[i]->info().endless && scene.description().media[i].kind->list() == "media")
      media.push_back(scene.media()[i].get());
  }
  return media;
}

/// What the leader's frames leave out of the others', and of the camera's path.
void tellOfOthers(const Scene& scene, const SceneMedium& leader, const FrameRequest& request,
                  Progress& progress) {
  constexpr double kRounding = 1e-6;  // [s]
  const MediumInfo& info = leader.info();
  const double end = info.times.back() + kRounding;
  for (const SceneMedium* medium : countedIn(scene)) {
    const MediumInfo& other = medium->info();
    if (medium == &leader || other.times.size() < 2)
      continue;
    const auto missed = [&](double time) {
      const auto next = std::ranges::lower_bound(info.times, time - kRounding);
      return next == info.times.end() || *next > time + kRounding;
    };
    const auto count = other.interpolates ? 0 : std::ranges::count_if(other.times, missed);
    const bool goesOn = !other.loops && other.times.back() > end;
    if (count == 0 && !goesOn)
      continue;
    progress.remark(
        Remark{RemarkCode::kLeftOut,
               fmt::format("the frames are those of {}, from {} to {} s{}{}", info.file,
                           plainNumber(info.times.front()), plainNumber(info.times.back()),
                           count > 0 ? fmt::format("; {} of the {} frames of {} are at other times",
                                                   count, other.times.size(), other.file)
                                     : "",
                           goesOn ? fmt::format("; {} goes on until {} s", other.file,
                                                plainNumber(other.times.back()))
                                  : "")}
            .in(other.file));
  }
  if (request.pathEnd && *request.pathEnd > end) {
    progress.remark(
        {RemarkCode::kLeftOut,
         fmt::format("the camera's path goes on until {} s; the frames of {} end at "
                     "{} s",
                     plainNumber(*request.pathEnd), info.file, plainNumber(info.times.back()))});
  }
}

/// Pictures of a film are shown equally long.
void tellOfUnevenTimes(const std::vector<FilmFrame>& frames, const MediumInfo& info, double speed,
                       Progress& progress) {
  constexpr double kUneven = 0.05;  // of the mean interval
  if (frames.size() < 3)
    return;
  double shortest = std::numeric_limits<double>::infinity(), longest = 0;
  for (std::size_t i = 1; i < frames.size(); ++i) {
    const double interval = frames[i].time - frames[i - 1].time;
    shortest = std::min(shortest, interval), longest = std::max(longest, interval);
  }
  const double mean =
      (frames.back().time - frames.front().time) / static_cast<double>(frames.size() - 1);
  if (longest - shortest <= kUneven * mean)
    return;
  progress.remark(
      Remark{RemarkCode::kChanged,
             fmt::format("{}: its frames are {} to {} s apart; the film shows each "
                         "of them for {:.3g} s",
                         info.file, plainNumber(shortest), plainNumber(longest), mean / speed)}
          .in(info.file));
}

ChosenFrames plainly(std::vector<FilmFrame> frames) {
  return {std::move(frames)};
}

}  // namespace

const SceneMedium* leaderOf(const Scene& scene) {
  const auto rank = [](const MediumInfo& info) {
    return std::tuple(info.times.size() > 1, !info.interpolates, info.times.back());
  };
  const SceneMedium* leader = nullptr;
  for (const SceneMedium* medium : countedIn(scene)) {
    if (!leader || rank(medium->info()) > rank(leader->info()))
      leader = medium;
  }
  return leader;
}

namespace {

Result<ChosenFrames> framesInTime(const FrameRequest& request, Scene& scene, Progress& progress) {
  const std::string& target = request.target;
  const SceneMedium* leader = leaderOf(scene);
  if (request.time) {
    VOLUTE_TRY(checkSceneTime(scene, *request.time));
    const int number = leader ? numberAt(leader->info(), *request.time) : 0;
    return ChosenFrames{{FilmFrame{number, *request.time}}};
  }
  if (!leader)
    return steadyFrames(request, scene).map(plainly);
  // What has one frame is shown as long as the camera moves.
  const MediumInfo& info = leader->info();
  if (info.times.size() < 2 && request.pathEnd && !request.frames && takesSeveral(target))
    return steadyFrames(request, scene).map(plainly);
  const bool film = isFilmPath(target);
  if (!request.frames && !takesSeveral(target)) {
    if (!showsOneFile(scene))
      return ChosenFrames{{FilmFrame{numberAt(info, 0), 0}}};
    ChosenFrames chosen{
        {FilmFrame{info.interpolates ? 0 : info.numbers.front(), info.times.front()}}};
    if (info.times.size() > 1) {
      VOLUTE_ASSIGN(const FirstSight first, firstSight(scene, progress));
      if (!first.reason.empty()) {
        const int number = numberAt(info, first.time);
        return ChosenFrames{
            {FilmFrame{number, first.time}},
            fmt::format("showing {}: {}",
                        info.interpolates
                            ? fmt::format("{} s", plainNumber(first.time, 4))
                            : fmt::format("frame {}", frameText(number, info.frameScale)),
                        first.reason)};
      }
      chosen.reason = fmt::format("showing the first of {} {}", info.times.size(),
                                  info.interpolates ? "steps" : "frames");
    }
    return chosen;
  }
  if (!request.frames)
    tellOfOthers(scene, *leader, request, progress);
  const FrameRange range = request.frames.value_or(FrameRange{});
  VOLUTE_ASSIGN(const auto positions, positionsOf(info, range));
  if (const auto text = beyondText(range, info.numbers, info.frameScale); !text.empty())
    progress.remark(
        Remark{RemarkCode::kDoubtful, fmt::format("{}: {}", info.file, text)}.in(info.file));
  if (film && info.interpolates && range.step > 1) {
    return failFor("frames", ErrorCode::kInvalidArgument,
                   "a film of {} has {:g} pictures a second between the first and the last "
                   "chosen frame, whatever the step ({}); leave it out, or write single pictures",
                   info.kind, request.rate, range.step);
  }
  const auto at = [&](int position) { return static_cast<std::size_t>(position); };
  if (film && info.interpolates) {
    return framesOfFilm(info.times[at(positions.front())], info.times[at(positions.back())],
                        request)
        .map(plainly);
  }
  std::vector<FilmFrame> frames;
  for (const int position : positions)
    frames.push_back({info.numbers[at(position)], info.times[at(position)]});
  if (film) {
    frames = heldInGaps(std::move(frames));
    tellOfUnevenTimes(frames, info, request.speed, progress);
  }
  return fitting(std::move(frames), target).map(plainly);
}

}  // namespace

Result<ChosenFrames> chooseFrames(const FrameRequest& request, Scene& scene, Progress& progress) {
  VOLUTE_ASSIGN(auto chosen, framesInTime(request, scene, progress));
  if (!request.orbit)
    return chosen;
  auto& frames = chosen.frames;
  if (!takesSeveral(request.target)) {
    return failFor("orbit", ErrorCode::kInvalidArgument,
                   "a single picture shows no turn; write a film, or put %04d into the name");
  }
  if (frames.size() == 1) {
    constexpr double kSecondsOfATurn = 10;
    const double count =
        std::round(std::abs(*request.orbit) / 360 * kSecondsOfATurn * request.rate);
    frames.assign(static_cast<std::size_t>(std::clamp(count, 2.0, 1e6)), frames.front());
    for (std::size_t i = 0; i < frames.size(); ++i) frames[i].number = static_cast<int>(i);
  }
  // The last picture is a step before the first one again.
  for (std::size_t i = 0; i < frames.size(); ++i)
    frames[i].turn = static_cast<double>(i) / static_cast<double>(frames.size());
  return chosen;
}

double framesPerSecond(const Scene& scene, const FrameRequest& request,
                       const std::vector<FilmFrame>& frames) {
  const SceneMedium* leader = leaderOf(scene);
  if (frames.size() < 2 || (leader && leader->info().interpolates) ||
      !(frames.back().time > frames.front().time))
    return request.rate;
  const double seconds = frames.back().time - frames.front().time;
  return request.speed * static_cast<double>(frames.size() - 1) / seconds;
}

}  // namespace volute
