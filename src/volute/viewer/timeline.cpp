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
  seek(time_);
  play(playing_);
}

void Timeline::setSpeed(double speed) {
  speed_ = std::clamp(speed, 0.01, 100.0);
}

void Timeline::seek(double time) {
  time_ = std::clamp(time, first(), last());
}

int Timeline::frame() const {
  const auto after = std::ranges::upper_bound(times_, time_);
  return static_cast<int>(std::max<std::ptrdiff_t>(after - times_.begin() - 1, 0));
}

void Timeline::step(int frames) {
  playing_ = false;
  const int next = std::clamp(frame() + frames, 0, this->frames() - 1);
  time_ = times_[static_cast<std::size_t>(next)];
}

void Timeline::advance(double seconds) {
  if (!playing_)
    return;
  time_ = first() + std::fmod(time_ - first() + seconds * speed_, period());
}

/// The last frame is shown as long as the one before it.
double Timeline::period() const {
  return 2 * last() - first() - times_[times_.size() - 2];
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
  const auto now = static_cast<std::size_t>(frame());
  const double next = now + 1 < times_.size() ? times_[now + 1] : first() + period();
  return (next - times_[now]) / speed_;
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
      later.time_ = time < first() + period() ? time : first();
      time = later.snapshotTime();
    } else {
      time = times_[static_cast<std::size_t>((frame() + i) % frames())];
    }
    if (time == shown)
      break;  // all of it
    if (next.empty() || next.back() != time)
      next.push_back(time);
  }
  return next;
}

}  // namespace volute
