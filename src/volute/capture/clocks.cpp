// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/capture/clocks.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "volute/io/film.hpp"

namespace volute {
namespace {

constexpr double kUsualRate = 25;

bool sameRate(double a, double b) {
  constexpr double kRounding = 5e-3;  // 29.97 and 30 are one rate, said in two ways
  return std::abs(a - b) <= kRounding * std::max(a, b);
}

/// What a film says; nothing where it cannot be opened, which is told when its pictures are wanted.
std::optional<double> rateOf(const CameraDraft& camera, std::uint64_t maxMemory) {
  if (camera.pictures.video.empty())
    return std::nullopt;
  const auto film = FilmReader::open(camera.pictures.video, maxMemory);
  if (!film || !(film->info().framesPerSecond > 0))
    return std::nullopt;
  return film->info().framesPerSecond;
}

/// The rates of films that say other ones than each other become those of their cameras.
void takeRatesOfFilms(CaptureDraft& draft, std::uint64_t maxMemory) {
  const bool stated = std::ranges::any_of(
      draft.cameras, [](const CameraDraft& camera) { return camera.framesPerSecond.has_value(); });
  const bool films = std::ranges::any_of(
      draft.cameras, [](const CameraDraft& camera) { return !camera.pictures.video.empty(); });
  if (stated || !films)
    return;
  std::vector<std::optional<double>> rates;
  std::optional<double> slowest, fastest;
  for (const CameraDraft& camera : draft.cameras) {
    const auto rate = rates.emplace_back(rateOf(camera, maxMemory));
    if (!rate)
      continue;
    slowest = std::min(slowest.value_or(*rate), *rate);
    fastest = std::max(fastest.value_or(*rate), *rate);
  }
  if (!slowest)
    return;
  if (sameRate(*slowest, *fastest)) {
    if (!draft.framesPerSecond) {
      draft.framesPerSecond = *slowest;
      draft.remarks.push_back(fmt::format("{:g} frames a second, as the films say", *slowest));
    }
    return;
  }
  if (!draft.framesPerSecond)
    draft.framesPerSecond = *slowest;
  std::vector<std::string> texts;
  for (std::size_t i = 0; i < rates.size(); ++i) {
    if (!rates[i])
      continue;
    draft.cameras[i].framesPerSecond = rates[i];
    texts.push_back(fmt::format("{} {:g}", draft.cameras[i].name, *rates[i]));
  }
  draft.remarks.push_back(fmt::format(
      "films have different rates, which were taken: {} pictures a second, of which the "
      "capture's {:g} frames a second are made",
      fmt::join(texts, ", "), *draft.framesPerSecond));
}

}  // namespace

PicturePlace PictureSource::placeOf(int frame) const {
  constexpr double kWhole = 0.01;
  const double place = (frame + frameShift - videoStart) * rate;
  const double nearest = std::round(place);
  if (std::abs(place - nearest) <= kWhole)
    return {static_cast<int>(nearest), 0};
  const double before = std::floor(place);
  return {static_cast<int>(before), place - before};
}

void settleClocks(CaptureDraft& draft, std::uint64_t maxMemory) {
  takeRatesOfFilms(draft, maxMemory);
  const double rate = draft.framesPerSecond.value_or(kUsualRate);
  for (CameraDraft& camera : draft.cameras) {
    if (camera.framesPerSecond)
      camera.pictures.rate = *camera.framesPerSecond / rate;
    if (camera.startTime)
      camera.pictures.videoStart = *camera.startTime * rate;
  }
}

Result<std::vector<int>> framesOfFilms(const CaptureDraft& draft, std::uint64_t maxMemory) {
  constexpr int kMax = 1 << 24;
  double first = 0, last = kMax;
  const CameraDraft *latest = nullptr, *earliest = nullptr;  // to begin, to end
  for (const CameraDraft& camera : draft.cameras) {
    const PictureSource& pictures = camera.pictures;
    if (pictures.video.empty())
      continue;
    auto film = FilmReader::open(pictures.video, maxMemory);
    const auto count = film ? film->countRest(kMax) : Result<int>(tl::unexpect, film.error());
    if (!count)
      return fail(count.error().code, "camera {}: {}", camera.name, count.error().message);
    const double begin = pictures.videoStart - pictures.frameShift;
    const double end = begin + (*count - 1) / pictures.rate;
    if (!latest || begin > first)
      latest = &camera, first = std::max(begin, 0.0);
    if (!earliest || end < last)
      earliest = &camera, last = end;
  }
  constexpr double kRounding = 1e-6;
  std::vector<int> frames;
  for (int n = static_cast<int>(std::ceil(first - kRounding)); n <= last + kRounding; ++n)
    frames.push_back(n);
  if (frames.empty()) {
    return fail(
        ErrorCode::kInvalidArgument,
        "The films have no frame in common: that of camera {} begins with frame {:.1f}, that "
        "of camera {} ends with frame {:.1f}; check video_start, start_time and frame_shift",
        latest->name, first, earliest->name, last);
  }
  return frames;
}

}  // namespace volute
