// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/render_moments.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "volute/cli/picture_writer.hpp"
#include "volute/grid/select_frames.hpp"
#include "volute/io/frame_pattern.hpp"

namespace volute::cli {
namespace {

Moment momentAt(const std::vector<VolumeLayer>& layers, double time) {
  Moment moment{.time = time};
  for (const VolumeLayer& layer : layers) moment.positions.push_back(layer.positionAt(time));
  if (!layers.empty())
    moment.number = layers.front().info().frameNumbers[moment.positions.front()];
  return moment;
}

/// Frames are those of the first volume; the others are shown as they are at its times.
Moment momentOf(const std::vector<VolumeLayer>& layers, int position) {
  Moment moment = momentAt(layers, layers.front().timeOf(position));
  moment.positions.front() = position;
  moment.number = layers.front().info().frameNumbers[position];
  return moment;
}

/// Scenes without a volume: frame n is at n / 25 s; without --frames as many as the fog has maps.
Result<std::vector<Moment>> momentsOfFog(const Arguments& arguments, const RenderSubject& subject,
                                         const std::string& target) {
  const bool several = isFilmPath(target) || FramePattern::isPattern(target);
  const auto chosen = arguments.find<FrameRange>("frames");
  if (const auto time = arguments.find<double>("time"))
    return std::vector{Moment{.time = *time}};
  if (!chosen && !several)
    return std::vector{Moment{}};
  double last = 0;
  for (const FogLayer& fog : subject.fogs) last = std::max(last, fog.timeOf(fog.frames() - 1));
  const FrameRange range = chosen.value_or(FrameRange{});
  const int begin = range.begin.value_or(0);
  const int end = range.end.value_or(static_cast<int>(std::lround(last * kUsualRate)) + 1);
  std::vector<Moment> moments;
  for (int n = begin; n < end; n += range.step)
    moments.push_back({.number = n, .time = n / kUsualRate});
  if (moments.empty())
    return fail(ErrorCode::kInvalidArgument, "--frames: there is no frame from {} to {}", begin,
                end);
  if (moments.size() > 1 && !several) {
    return fail(ErrorCode::kInvalidArgument,
                "{} pictures do not fit into '{}'; put %04d for the frame's number into its name",
                moments.size(), target);
  }
  return moments;
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
    moments.push_back({.number = i, .time = std::min(first + i * speed / kUsualRate, last)});
  return moments;
}

/// The stored frames of a volume or of a case of smoke.
struct Stored {
  std::string file;
  std::vector<double> times;  ///< [s], of the scene
  std::vector<int> numbers;
  bool loops = false;

  explicit Stored(const VolumeLayer& layer) : file(layer.path()) {
    numbers = layer.info().frameNumbers;
    for (int i = 0; i < layer.info().frames; ++i) times.push_back(layer.timeOf(i));
    loops = layer.appearance().clock.loop;
  }

  template <class Layer>
  explicit Stored(const Layer& layer) : file(layer.description().file) {
    for (int i = 0; i < layer.steps(); ++i) {
      times.push_back(layer.timeOf(i));
      numbers.push_back(layer.numberOf(i));
    }
    loops = layer.description().clock.loop;
  }

  /// The last frame lasts as long as the one before. A lone one lasts for ever.
  double end() const {
    const std::size_t n = times.size();
    return n < 2 || loops ? std::numeric_limits<double>::infinity()
                          : 2 * times[n - 1] - times[n - 2];
  }

  Result<std::vector<int>> positions(const FrameRange& range) const {
    VolumeInfo info;
    info.frames = static_cast<int>(numbers.size());
    info.frameNumbers = numbers;
    auto chosen = selectPositions(info, range);
    if (chosen)
      return chosen;
    return fail(ErrorCode::kInvalidArgument, "{}: {}", file, chosen.error().message);
  }
};

/// --time must lie before the end of one medium at least, where all of them end. Fog never does.
Status checkTime(const RenderSubject& subject, double time) {
  constexpr double kRounding = 1e-9;
  std::vector<Stored> all;
  for (const VolumeLayer& layer : subject.layers) all.emplace_back(layer);
  for (const SmokeLayer& layer : subject.smokes) all.emplace_back(layer);
  for (const FdsLayer& layer : subject.fdsCases) all.emplace_back(layer);
  const Stored* longest = nullptr;
  for (const Stored& stored : all) {
    if (stored.times.size() > 1 && (!longest || stored.end() > longest->end()))
      longest = &stored;
  }
  if (!longest || !subject.fogs.empty() ||
      time <= longest->end() + kRounding * (1 + std::abs(longest->end())))
    return {};
  return fail(ErrorCode::kInvalidArgument,
              "--time: {:g} s is past the end: {} has {} frames from {:g} to {:g} s", time,
              longest->file, longest->times.size(), longest->times.front(), longest->times.back());
}

/// Frames are the steps of the case; films go through its time, 25 pictures a second.
Result<std::vector<Moment>> momentsOfSmoke(const Stored& smoke, const Arguments& arguments,
                                           const RenderSubject& subject, const std::string& target,
                                           Progress& progress) {
  const std::size_t steps = smoke.times.size();
  if (const auto time = arguments.find<double>("time"))
    return std::vector{Moment{.time = *time}};
  const bool film = isFilmPath(target), several = film || FramePattern::isPattern(target);
  if (!arguments.given("frames") && !several) {
    if (steps > 1 && !subject.scene) {
      progress.remark(
          fmt::format("showing the first of {} steps; --time or --frames choose others", steps));
    }
    return std::vector{Moment{.time = subject.scene ? 0 : smoke.times.front()}};
  }
  const FrameRange range = arguments.find<FrameRange>("frames").value_or(FrameRange{});
  VOLUTE_ASSIGN(const auto positions, smoke.positions(range));
  if (film && range.step > 1) {
    return fail(ErrorCode::kInvalidArgument,
                "--frames: a film of smoke has 25 pictures a second between the first and the last "
                "chosen frame, whatever the step ({}); leave it out, or write stills",
                range.step);
  }
  if (film) {
    return momentsOfFilm(smoke.times[positions.front()], smoke.times[positions.back()],
                         arguments.get<double>("speed"));
  }
  std::vector<Moment> moments;
  for (const int position : positions)
    moments.push_back({.number = smoke.numbers[position], .time = smoke.times[position]});
  if (moments.size() > 1 && !several) {
    return fail(ErrorCode::kInvalidArgument,
                "{} pictures do not fit into '{}'; put %04d for the frame's number into its name",
                moments.size(), target);
  }
  return moments;
}

}  // namespace

Result<std::vector<Moment>> momentsOf(const Arguments& arguments, const RenderSubject& subject,
                                      const std::string& target, Progress& progress) {
  const auto& layers = subject.layers;
  if (const auto time = arguments.find<double>("time"))
    VOLUTE_TRY(checkTime(subject, *time));
  if (layers.empty() && !subject.smokes.empty())
    return momentsOfSmoke(Stored(subject.smokes.front()), arguments, subject, target, progress);
  if (layers.empty() && !subject.fdsCases.empty())
    return momentsOfSmoke(Stored(subject.fdsCases.front()), arguments, subject, target, progress);
  if (layers.empty())
    return momentsOfFog(arguments, subject, target);
  if (const auto time = arguments.find<double>("time"))
    return std::vector{momentAt(layers, *time)};
  const VolumeInfo& info = layers.front().info();
  const bool several = isFilmPath(target) || FramePattern::isPattern(target);
  if (!arguments.given("frames") && !several) {
    if (subject.scene)
      return std::vector{momentAt(layers, 0)};
    if (info.frames > 1) {
      progress.remark(fmt::format(
          "showing the first of {} frames; --time or --frames choose others", info.frames));
    }
    return std::vector{momentOf(layers, 0)};
  }
  VOLUTE_ASSIGN(const auto positions,
                selectPositions(info, arguments.find<FrameRange>("frames").value_or(FrameRange{})));
  if (positions.size() > 1 && !several) {
    return fail(ErrorCode::kInvalidArgument,
                "{} pictures do not fit into '{}'; put %04d for the frame's number into its name",
                positions.size(), target);
  }
  std::vector<Moment> moments;
  for (const int position : positions) moments.push_back(momentOf(layers, position));
  return moments;
}

double framesPerSecond(const std::vector<Moment>& moments) {
  if (moments.size() < 2)
    return kUsualRate;
  return static_cast<double>(moments.size() - 1) / (moments.back().time - moments.front().time);
}

}  // namespace volute::cli
