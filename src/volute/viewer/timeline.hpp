// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>
#include <utility>
#include <vector>

namespace volute {

/// The viewer's clock: plays, is scrubbed, has a speed, begins again at the end of its loop.
class Timeline {
 public:
  static constexpr double kSlowest = 0.125, kFastest = 8;  ///< that controls offer

  /// `times`: when frames begin [s], ascending, one at least.
  void setTimes(std::vector<double> times);

  double time() const { return time_; }  ///< [s]

  /// Between times it is interpolated; else each of them holds until the next.
  void setInterpolates(bool on) { interpolates_ = on; }

  /// Of the snapshot that is to be shown [s]: while it plays that of the frame, or, where it is
  /// interpolated, the last of kRate a second of the clock on the wall; else time().
  double snapshotTime() const;

  /// How long it is shown [s] of the clock on the wall.
  double snapshotSeconds() const;

  /// Those that playing would show next, in order, the one that is shown left out.
  std::vector<double> ahead(int count) const;

  double first() const { return times_.front(); }

  double last() const { return times_.back(); }

  bool moves() const { return times_.size() > 1; }

  bool playing() const { return playing_; }

  void play(bool on) { playing_ = on && moves(); }

  double speed() const { return speed_; }

  /// Times as fast, 0.01 to 100.
  void setSpeed(double speed);

  /// Clamped to the first and the last frame.
  void seek(double time);

  /// What is played, from the beginning of a frame on [s]: all, unless setLoop() said otherwise.
  double loopBegin() const { return loop_ ? loop_->first : first(); }

  double loopEnd() const { return loop_ ? loop_->second : last(); }

  bool loopsPart() const { return loop_.has_value(); }

  /// An empty range: all.
  void setLoop(double begin, double end);

  /// From time() on to the loop's end, or to the last frame where that is before it; and up to it.
  void loopFromHere();
  void loopToHere();

  /// To the beginning of the frame before or after; stops.
  void step(int frames);

  /// Which frame is shown, from 0.
  int frame() const;

  int frames() const { return static_cast<int>(times_.size()); }

  /// Frames a second, where there are no gaps between them.
  double rate() const;

  /// Goes on by so many seconds of the clock on the wall.
  void advance(double seconds);

 private:
  static constexpr double kRate = 25;  ///< [1/s]

  double endOf(int frame) const;  ///< [s]: the last one takes as long as the one before it
  int frameAt(double time) const;
  double period() const;  ///< [s] of a loop

  std::vector<double> times_{0.0};
  double time_ = 0;
  double speed_ = 1;
  bool playing_ = false;
  bool interpolates_ = false;
  std::optional<std::pair<double, double>> loop_{};  ///< [s]
};

}  // namespace volute
