// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/timeline.hpp"

#include <algorithm>
#include <cmath>

namespace volute {

void Timeline::setTimes(std::vector<double> times) {
  times_ = std::move(times);
  if (times_.empty())
    times_ = {0.0};
  if (loop_)
    setLoop(loop_->first, loop_->second);
  seek(time_);
  play(playing_);
}

void Timeline::setSpeed(double speed) {
  speed_ = std::clamp(speed, 0.01, 100.0);
}

void Timeline::seek(double time) {
  time_ = std::clamp(time, first(), last());
}

void Timeline::setLoop(double begin, double end) {
  begin =
      std::max(interpolates_ ? begin : times_[static_cast<std::size_t>(frameAt(begin))], first());
  end = std::min(end, last());
  const bool part = begin < end && (begin > first() || end < last());
  loop_ = part ? std::optional(std::pair(begin, end)) : std::nullopt;
}

void Timeline::loopFromHere() {
  setLoop(time_, time_ < loopEnd() ? loopEnd() : last());
}

void Timeline::loopToHere() {
  setLoop(time_ > loopBegin() ? loopBegin() : first(), time_);
}

int Timeline::frameAt(double time) const {
  const auto after = std::ranges::upper_bound(times_, time);
  return static_cast<int>(std::max<std::ptrdiff_t>(after - times_.begin() - 1, 0));
}

int Timeline::frame() const {
  return frameAt(time_);
}

void Timeline::step(int frames) {
  playing_ = false;
  const int next = std::clamp(frame() + frames, 0, this->frames() - 1);
  time_ = times_[static_cast<std::size_t>(next)];
}

void Timeline::advance(double seconds) {
  if (!playing_)
    return;
  const double begin = loopBegin(), length = period();
  const double gone = time_ >= begin && time_ <= begin + length ? time_ - begin : 0;
  time_ = begin + std::fmod(gone + seconds * speed_, length);
}

double Timeline::rate() const {
  std::vector<double> each;
  for (std::size_t i = 1; i < times_.size(); ++i) each.push_back(times_[i] - times_[i - 1]);
  if (each.empty())
    return 0;
  const auto middle = each.begin() + std::ssize(each) / 2;
  std::ranges::nth_element(each, middle);
  return 1 / *middle;
}

double Timeline::endOf(int frame) const {
  const auto next = static_cast<std::size_t>(frame) + 1;
  return next < times_.size() ? times_[next] : 2 * last() - times_[times_.size() - 2];
}

double Timeline::period() const {
  return (loop_ && interpolates_ ? loopEnd() : endOf(frameAt(loopEnd()))) - loopBegin();
}

double Timeline::snapshotTime() const {
  if (!playing_)
    return time_;
  if (!interpolates_)
    return times_[static_cast<std::size_t>(frame())];
  constexpr double kRounding = 1e-6;
  const double step = speed_ / kRate;
  return std::min(first() + step * std::floor((time_ - first()) / step + kRounding), last());
}

double Timeline::snapshotSeconds() const {
  if (interpolates_ || !moves())
    return 1 / kRate;
  return (endOf(frame()) - times_[static_cast<std::size_t>(frame())]) / speed_;
}

std::vector<double> Timeline::ahead(int count) const {
  std::vector<double> next;
  if (!moves())
    return next;
  Timeline later = *this;
  later.playing_ = true;
  const double step = speed_ / kRate;
  const double shown = later.snapshotTime();
  for (int i = 1; i <= count; ++i) {
    double time = 0;
    if (interpolates_) {
      time = later.snapshotTime() + step;
      later.time_ = time < loopBegin() + period() ? time : loopBegin();
      time = later.snapshotTime();
    } else {
      const int begin = frameAt(loopBegin()), loop = frameAt(loopEnd()) + 1 - begin;
      time =
          times_[static_cast<std::size_t>(begin + (frame() - begin + i + frames() * loop) % loop)];
    }
    if (time == shown)
      break;  // all of it
    if (next.empty() || next.back() != time)
      next.push_back(time);
  }
  return next;
}

}  // namespace volute
