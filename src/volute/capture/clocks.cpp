// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/capture/clocks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "volute/io/film.hpp"

namespace volute {
namespace {

constexpr int kMaxPictures = 1 << 24;  // of a film

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

/// From the slowest to the fastest.
struct RateRange {
  double slowest = std::numeric_limits<double>::infinity(), fastest = 0;

  void add(double rate) {
    slowest = std::min(slowest, rate);
    fastest = std::max(fastest, rate);
  }

  bool alike() const { return sameRate(slowest, fastest); }
};

/// The rates of films that say other ones than each other become those of their cameras. What is
/// stated counts, and is remarked on where films say otherwise.
void takeRatesOfFilms(CaptureDraft& draft, std::uint64_t maxMemory) {
  std::vector<std::optional<double>> own;
  RateRange films, taken;  // as the films say; with what cameras state
  bool anyStated = false;
  std::vector<std::string> contradicted, texts;
  for (const CameraDraft& camera : draft.cameras) {
    const auto said = own.emplace_back(rateOf(camera, maxMemory));
    if (!said)
      continue;
    const double rate = camera.framesPerSecond.value_or(*said);
    films.add(*said), taken.add(rate);
    anyStated = anyStated || camera.framesPerSecond;
    if (!sameRate(rate, *said))
      contradicted.push_back(fmt::format("{} {:g}, its film {:g}", camera.name, rate, *said));
  }
  if (taken.fastest == 0)
    return;
  if (!contradicted.empty())
    draft.remarks.emplace_back(
        RemarkCode::kNote,
        fmt::format("cameras state other rates than their films, which count: {} pictures a second",
                    fmt::join(contradicted, "; ")));
  const bool stated = draft.framesPerSecond.has_value();
  const double rate = draft.framesPerSecond.value_or(taken.slowest);
  draft.framesPerSecond = rate;
  if (stated && films.alike()) {
    if (!anyStated && !sameRate(films.slowest, rate))
      draft.remarks.emplace_back(
          RemarkCode::kDoubtful,
          fmt::format(
              "the films say {:g} pictures a second, and {:g} frames a second are stated, which "
              "counts: "
              "each picture is taken as a frame; unless that is slow motion, state the cameras' "
              "rates",
              films.slowest, rate));
    return;
  }
  if (taken.alike()) {
    draft.remarks.push_back(
        fmt::format("{:g} frames a second, as the {} say", rate, anyStated ? "cameras" : "films"));
    return;
  }
  for (std::size_t i = 0; i < own.size(); ++i) {
    if (!own[i])
      continue;
    auto& of = draft.cameras[i].framesPerSecond;
    if (!of)
      of = own[i];
    texts.push_back(fmt::format("{} {:g}", draft.cameras[i].name, *of));
  }
  draft.remarks.emplace_back(
      RemarkCode::kAssumed,
      fmt::format(
          "films have different rates, which were taken: {} pictures a second, of which the "
          "capture's {:g} frames a second are made",
          fmt::join(texts, ", "), rate));
}

/// What a film says of its pictures that a person should know.
void remarkOnFilm(const CameraDraft& camera, const FilmInfo& film, std::vector<Remark>& remarks) {
  const auto told = [&](RemarkCode code, const std::string& what) {
    remarks.emplace_back(
        code, fmt::format("camera {}: {} {}", camera.name, camera.pictures.video.string(), what));
  };
  if (film.interlaced)
    told(RemarkCode::kAssumed,
         "is interlaced: each of its pictures is of two times, and is taken to be of one");
  if (film.otherStreams > 0)
    told(RemarkCode::kLeftOut,
         fmt::format("has {} more streams of video, which are not read", film.otherStreams));
  if (film.turned != 0)
    told(RemarkCode::kAssumed,
         fmt::format("says that its pictures are to be shown turned by {} degrees: they are turned "
                     "so, and the calibration is taken to be of pictures that were turned",
                     film.turned));
  if (film.pixelAspect != 1)
    told(RemarkCode::kAssumed,
         fmt::format("says that its pixels are {:.4g} times as wide as high: they are taken as "
                     "stored, {} x {}, and the calibration to be of such pictures",
                     film.pixelAspect, film.width, film.height));
}

/// Where the pictures of a film lie, if it says so and not that they follow each other evenly.
/// @param rate  of the camera's pictures, as it was stated or as the film says
void takeTimesOfFilm(CameraDraft& camera, double rate, std::vector<Remark>& remarks,
                     std::uint64_t maxMemory) {
  constexpr double kEven = 0.1;        // of the time between two pictures
  constexpr double kRounding = 1e-3;   // [s] to which containers round times
  constexpr double kOtherSpeed = 1.5;  // a stated rate that is so far off is that of slow motion
  PictureSource& pictures = camera.pictures;
  if (pictures.video.empty())
    return;
  auto film = FilmReader::open(pictures.video, maxMemory);
  if (film)
    remarkOnFilm(camera, film->info(), remarks);
  const auto times =
      film ? film->restOfTimes(kMaxPictures) : fail(film.error().code, film.error().hints, "");
  if (!times || times->empty())
    return;  // which is told when its pictures are wanted
  pictures.filmPictures = static_cast<int>(times->size());
  if (camera.filmLength && *camera.filmLength != pictures.filmPictures)
    remarks.emplace_back(
        RemarkCode::kDoubtful,
        fmt::format("camera {}: {} has {} pictures, not the {} that are stated (frame_num); all "
                    "are used",
                    camera.name, pictures.video.string(), pictures.filmPictures,
                    *camera.filmLength));
  const double span = times->back() - times->front();
  const double gap = span / std::max(pictures.filmPictures - 1, 1);
  if (!(gap > 0))
    return;
  double shortest = gap, longest = gap, off = 0;
  for (std::size_t i = 1; i < times->size(); ++i) {
    const double step = (*times)[i] - (*times)[i - 1];
    shortest = std::min(shortest, step), longest = std::max(longest, step);
    off =
        std::max(off, std::abs((*times)[i] - times->front() - static_cast<double>(i) * gap) / gap);
  }
  if (off <= std::max(kEven, kRounding / gap))
    return;
  if (!(shortest > 0)) {
    remarks.emplace_back(
        RemarkCode::kAssumed,
        fmt::format("camera {}: {} states one time for several of its pictures, so that they are "
                    "taken to follow each other evenly",
                    camera.name, pictures.video.string()));
    return;
  }
  const auto far = [&](double other) {
    return !(std::max(rate / other, other / rate) <= kOtherSpeed);
  };
  const bool otherSpeed = far(1 / gap) && far(film->info().framesPerSecond);
  for (const double time : *times)
    pictures.filmPlaces.push_back((time - times->front()) * (otherSpeed ? 1 / gap : rate));
  remarks.push_back(fmt::format(
      "camera {}: the pictures of {} follow each other after {:.3g} to {:.3g} s: each is taken at "
      "the time that the film states",
      camera.name, pictures.video.string(), shortest, longest));
}

}  // namespace

PicturePlace PictureSource::placeOf(int frame) const {
  constexpr double kWhole = 0.01;
  double place = (frame + frameShift - videoStart) * rate;
  if (!filmPlaces.empty()) {  // between which pictures, and how far from the one to the other
    const auto after = std::ranges::upper_bound(filmPlaces, place);
    const auto last = static_cast<int>(filmPlaces.size()) - 1;
    const int before =
        std::clamp(static_cast<int>(after - filmPlaces.begin()) - 1, 0, std::max(last - 1, 0));
    const double from = placeInFilm(before);
    const double gap = last > 0 ? placeInFilm(before + 1) - from : 1;
    place = before + (place - from) / gap;
  }
  const double nearest = std::round(place);
  if (std::abs(place - nearest) <= kWhole)
    return {static_cast<int>(nearest), 0};
  const double before = std::floor(place);
  return {static_cast<int>(before), place - before};
}

std::string framesBeforeZero(int first) {
  return fmt::format("{} before 0 and left out: state start times so that all are from 0 on",
                     first == -1 ? "frame -1 is" : fmt::format("frames {} to -1 are", first));
}

Result<int> picturesOfFilm(const PictureSource& pictures, std::uint64_t maxMemory) {
  if (pictures.filmPictures > 0)
    return pictures.filmPictures;
  VOLUTE_ASSIGN(auto film, FilmReader::open(pictures.video, maxMemory));
  VOLUTE_ASSIGN(const auto times, film.restOfTimes(kMaxPictures));
  return static_cast<int>(times.size());
}

void settleClocks(CaptureDraft& draft, std::uint64_t maxMemory) {
  takeRatesOfFilms(draft, maxMemory);
  const double rate = draft.framesPerSecond.value_or(kUnstatedRate);
  for (CameraDraft& camera : draft.cameras) {
    takeTimesOfFilm(camera, camera.framesPerSecond.value_or(rate), draft.remarks, maxMemory);
    if (camera.framesPerSecond)
      camera.pictures.rate = *camera.framesPerSecond / rate;
    if (camera.startTime)
      camera.pictures.videoStart = *camera.startTime * rate;
  }
}

Result<std::vector<int>> framesOfFilms(CaptureDraft& draft, std::uint64_t maxMemory) {
  double first = 0, last = kMaxPictures, firstOfAny = last, lastOfAny = first;
  const CameraDraft *latest = nullptr, *earliest = nullptr;  // to begin, to end
  for (const CameraDraft& camera : draft.cameras) {
    const PictureSource& pictures = camera.pictures;
    if (pictures.video.empty())
      continue;
    const auto count = picturesOfFilm(pictures, maxMemory);
    if (!count)
      return fail(count.error().code, count.error().hints, "camera {}: {}", camera.name,
                  count.error().message);
    const double begin = pictures.videoStart - pictures.frameShift;
    const double end = begin + pictures.placeInFilm(*count - 1) / pictures.rate;
    firstOfAny = std::min(firstOfAny, begin), lastOfAny = std::max(lastOfAny, end);
    if (!latest || begin > first)
      latest = &camera, first = begin;
    if (!earliest || end < last)
      earliest = &camera, last = end;
  }
  constexpr double kRounding = 1e-6;
  std::vector<int> frames;
  const int begin = static_cast<int>(std::ceil(first - kRounding));
  for (int n = std::max(begin, 0); n <= last + kRounding; ++n) frames.push_back(n);
  if (frames.empty()) {
    return fail(
        ErrorCode::kInvalidArgument,
        "The films have no frame in common: that of camera {} begins with frame {:.1f}, that "
        "of camera {} ends with frame {:.1f}; check video_start, start_time and frame_shift",
        latest->name, first, earliest->name, last);
  }
  // By less than a frame films differ that were begun and stopped together.
  if (lastOfAny - last >= 1) {
    draft.remarks.emplace_back(
        RemarkCode::kLeftOut,
        fmt::format("camera {}: its film ends with frame {:.0f}, others reach frame {:.0f}: what "
                    "comes after is left out",
                    earliest->name, last, lastOfAny));
  }
  if (begin < 0)
    draft.remarks.emplace_back(RemarkCode::kLeftOut, framesBeforeZero(begin));
  if (std::max(first, 0.0) - firstOfAny >= 1 && begin >= 0) {
    draft.remarks.emplace_back(
        RemarkCode::kLeftOut,
        fmt::format("camera {}: its film begins with frame {:.0f}, others with frame {:.0f}: what "
                    "comes before is left out",
                    latest->name, first, firstOfAny));
  }
  return frames;
}

}  // namespace volute
