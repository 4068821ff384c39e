// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/render_moments.hpp"

#include <algorithm>
#include <cmath>

#include "volute/cli/picture_writer.hpp"
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

/// The stored steps of a case of smoke.
struct Steps {
  std::string file;
  std::vector<double> times;  ///< [s], of the scene

  template <class Layer>
  explicit Steps(const Layer& layer) : file(layer.description().file) {
    for (int i = 0; i < layer.steps(); ++i) times.push_back(layer.timeOf(i));
  }
};

/// Frames are the steps of the case; films go through its time, 25 pictures a second.
Result<std::vector<Moment>> momentsOfSmoke(const Steps& smoke, const Arguments& arguments,
                                           const RenderSubject& subject, const std::string& target,
                                           Progress& progress) {
  const int steps = static_cast<int>(smoke.times.size());
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
  const int begin = std::max(range.begin.value_or(0), 0);
  const int end = std::min(range.end.value_or(steps), steps);
  if (begin >= end) {
    return fail(ErrorCode::kInvalidArgument,
                "--frames: {} has the steps 0 to {}; there is none from {} to {}", smoke.file,
                steps - 1, begin, range.end.value_or(steps));
  }
  if (film) {
    return momentsOfFilm(smoke.times[begin], smoke.times[end - 1], arguments.get<double>("speed"));
  }
  std::vector<Moment> moments;
  for (int n = begin; n < end; n += range.step)
    moments.push_back({.number = n, .time = smoke.times[n]});
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
  if (layers.empty() && !subject.smokes.empty())
    return momentsOfSmoke(Steps(subject.smokes.front()), arguments, subject, target, progress);
  if (layers.empty() && !subject.fdsCases.empty())
    return momentsOfSmoke(Steps(subject.fdsCases.front()), arguments, subject, target, progress);
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
