// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/playback.hpp"

#include <algorithm>
#include <cmath>

#include "volute/viewer/error_text.hpp"
#include "volute/viewer/language.hpp"

namespace volute {
namespace {

constexpr double kHeldTime = 1e-9;
constexpr int kAhead = 64;  ///< snapshots that are loaded ahead, memory permitting

}  // namespace

void Playback::begin(double time) {
  marks_.clear();
  timeline_.setLoop(0, 0);
  timeline_.setTimes({time});
  timeline_.seek(time);
  requested_ = time;
}

void Playback::setFrames(const DocumentInfo& info, bool another) {
  timeline_.setInterpolates(info.interpolates);
  const double time = timeline_.time();
  timeline_.setTimes(info.times);
  if (another)
    timeline_.seek(std::max(time, requested_));
}

void Playback::request() {
  const bool plays = timeline_.playing();
  const double wanted = timeline_.snapshotTime(), period = timeline_.snapshotSeconds();
  const bool rests = played_ && !plays, another = std::abs(wanted - requested_) > kHeldTime;
  if (plays && !played_)
    document_.loader().prepare(timeline_.ahead(kAhead), period);
  if (document_.info() && !document_.opening() && (another || rests)) {
    requested_ = wanted;
    document_.loader().request(requested_, plays ? timeline_.ahead(kAhead) : std::vector<double>(),
                               period);
  }
  played_ = plays;
}

void Playback::toggleMark() {
  const double time = timeline_.time();
  if (marks_.erase(time) == 0)
    marks_.insert(time);
}

void Playback::seekMark(int side) {
  const auto next =
      side > 0 ? marks_.upper_bound(timeline_.time()) : marks_.lower_bound(timeline_.time());
  if (side > 0 && next != marks_.end())
    timeline_.seek(*next);
  else if (side < 0 && next != marks_.begin())
    timeline_.seek(*std::prev(next));
}

void Playback::noteShown(double seconds, double time) {
  constexpr double kCounted = 1;  // [s]
  if (!timeline_.playing()) {
    counting_ = shownRate_ = 0;
    shownCount_ = 0;
    return;
  }
  shownCount_ += std::exchange(shownTime_, time) != time;
  counting_ += seconds;
  if (counting_ < kCounted)
    return;
  shownRate_ = shownCount_ / counting_;
  counting_ = 0;
  shownCount_ = 0;
}

double Playback::budget(double most) const {
  constexpr double kShare = 0.6, kMin = 0.012;
  return timeline_.playing() ? std::clamp(kShare * timeline_.snapshotSeconds(), kMin, most) : most;
}

void Playback::beginFilm(const FilmOrder& order, const PictureMakers& makers) {
  timeline_.play(false);
  filmFailure_.clear();
  auto film = FilmExport::begin(order, makers);
  if (!film)
    return failFilm(viewerText(film.error()));
  film_ = std::move(*film);
  document_.loader().freeze();
}

void Playback::cancelFilm() {
  if (film_)
    endFilm(film_->keeps() ? tr("the film is stopped; Make film goes on where it was") : "");
}

void Playback::endFilm(std::string message) {
  if (!film_)
    return;
  document_.say(std::move(message));
  film_.reset();
  filmAsked_.reset();
  if (filmScene_ && *filmScene_)
    document_.loader().discard(std::move((*filmScene_)->scene));
  filmScene_.reset();
  document_.loader().thaw();
}

/// Nobody may be there to read it.
void Playback::failFilm(std::string why) {
  filmFailure_ = std::move(why);
  endFilm("");
}

void Playback::takeFilmScene(Result<LoadedScene> scene) {
  if (film_)
    filmScene_ = std::move(scene);
}

void Playback::goOnWithFilm(const ViewPicture& picture) {
  if (!film_)
    return;
  if (film_->finished()) {
    const int kept = film_->resumed();
    const std::string resumed =
        kept > 0 ? fmt::format(fmt::runtime(tr("; {} pictures were kept")), kept) : "";
    const std::string lacked = film_->remark().empty() ? "" : "; " + film_->remark();
    const FilmOrder& order = film_->order();
    return endFilm(fmt::format("{} is written: {:.3g} s{}{}", order.target,
                               order.frames() / order.rate, resumed, lacked));
  }
  const auto wanted = film_->wantedTime();
  if (wanted && wanted != filmAsked_) {
    filmAsked_ = wanted;
    document_.loader().requestFrozen(
        {.time = *wanted, .openGl = picture.mayUseGl(film_->order().renderer)});
  }
  if (filmScene_ && !*filmScene_)
    return failFilm(fmt::format("{}: {}", film_->order().target, viewerText(filmScene_->error())));
  const bool there = wanted && filmScene_ && (*filmScene_)->time == *wanted;
  if (const Status done = film_->step(there ? (*filmScene_)->scene : nullptr); !done)
    failFilm(viewerText(done.error()));
}

}  // namespace volute
