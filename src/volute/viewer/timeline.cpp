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
  // The last frame is shown as long as the one before it.
  const double tail = last() - times_[times_.size() - 2];
  const double period = last() - first() + tail;
  time_ = first() + std::fmod(time_ - first() + seconds * speed_, period);
}

}  // namespace volute
