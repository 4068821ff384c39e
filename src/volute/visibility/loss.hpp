// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/visibility/survey.hpp"

// When something is no longer so, from what is known at stored times.

namespace volute {

/// Which time a loss between two stored times is given.
enum class RoundTime {
  kDown,  ///< the last one at which it was still so: on the safe side
  kNone,  ///< interpolated
  kUp,    ///< the first one at which it is no longer so
};

/// "down", "none", "up".
[[nodiscard]] Result<RoundTime> roundTime(std::string_view name);
std::string_view nameOf(RoundTime round);

/// The first loss at each of many places [s]; infinite where there is none. What is not so when it
/// is first looked at is lost then. down <= none <= up.
///
/// A place whose air is not known all along has an answer until known[place] alone: nothing is lost
/// there until then. A loss that is noted for it is one that is seen later: it comes at the latest
/// then.
struct LossTimes {
  std::vector<double> down, none, up;
  std::vector<double> known;  ///< [s]; infinite: all along; -infinite: never

  explicit LossTimes(std::size_t places = 0);

  const std::vector<double>& by(RoundTime round) const;

  /// Whether the loss, or that there is none, is certain.
  bool complete(std::size_t place) const { return known[place] > 0 && std::isinf(known[place]); }

  /// The time of a place that is complete; NaN of another.
  double answer(std::size_t place, RoundTime round) const;

  /// Answers of all places.
  std::vector<double> answers(RoundTime round) const;

  /// Keeps the first loss of a place.
  void note(std::size_t place, double last, double between, double first) {
    if (first < up[place]) {
      down[place] = last;
      none[place] = between;
      up[place] = first;
    }
  }

  /// From `time` on nothing is known of a place; -infinite: nothing ever was.
  void lose(std::size_t place, double time) { known[place] = std::min(known[place], time); }
};

/// A level that is reached, at each of many places: linear between the times at which it is known.
class LevelWatch {
 public:
  /// Lost when the value reaches `limit` from below, or, of falling ones, from above.
  LevelWatch(std::size_t places, double limit, bool falling = false);

  /// Times ascend. NaN: not known at that time.
  void update(double now, std::span<const double> values);

  /// Of one place. Places may be noted in parallel.
  /// @param span  the stored times around `now` from which the value comes: a loss is between them
  void note(std::size_t place, double now, double value, const StoredSpan& span);

  /// Somebody is at a place from `since` on, to whom nothing from before matters.
  void begin(std::size_t place, double since);

  /// Whether anything is known of a place since then.
  bool hasBegun(std::size_t place) const {
    return before_[place].known || before_[place].gap || before_[place].lost;
  }

  /// Nothing is known of a place, since it was known last.
  void lose(std::size_t place);

  const LossTimes& times() const { return loss_; }

  double limit() const { return limit_; }

  static constexpr std::size_t kBytesOfPlace = 80;  ///< that are kept of each

 private:
  struct Before {
    double time = 0, from = 0, value = 0;
    double since = -std::numeric_limits<double>::infinity();  // nobody was there before
    bool known = false;                                       // time, from and value are
    bool gap = false;  // since then, or from the beginning on
    bool lost = false;
  };

  double limit_, sign_;
  LossTimes loss_;
  std::vector<Before> before_;
};

/// When no sign of a set is seen any more from eyes that stay where they are: the ASET map
/// (available safe egress time) by visibility. Between two times the optical depth of each line is
/// linear, as the smoke is, and what is opaque is as at the first of them; times at which something
/// opaque comes or goes are given twice, with what was and with what is. Where a sign may be seen
/// on lines alone on which the smoke is not known everywhere, nothing is known.
///
/// A sign is in sight where nothing opaque hides it and it can be read in clear air. Before an eye
/// has one of a set in sight, nothing is lost there: something opaque may open later.
///
/// What is kept of each eye is small, as there may be millions: times are positions in a list, and
/// bounds are followed apart from when they first differ.
class SignLoss {
 public:
  /// @param sets  positions in `signs`, any number of sets.
  /// @param factors  each for one more set, of the first set's signs, whose C are multiplied by it,
  /// or the extinction divided. latest() is not known of these.
  SignLoss(std::span<const SightTarget> signs, std::vector<std::vector<std::size_t>> sets,
           std::size_t eyes, std::vector<double> factors = {});

  /// @param sightings  as lookAround gives them at `now`, the same eyes each time; `now` ascends.
  void update(double now, std::span<const Sighting> sightings);

  /// Calls of update() at different times, one less.
  static constexpr std::size_t kMaxTimes = (std::size_t{1} << 21) - 3;

  /// [bytes] that are kept of an eye for each set, for each factor, and for each sign.
  static constexpr std::size_t kBytesOfSet = 48, kBytesOfFactor = 32, kBytesOfSign = 17;

  /// Nothing is known of what was before the first time.
  void loseAll();

  /// Nor of what comes after the last one.
  void loseRest();

  /// At the field's depths.
  LossTimes times(std::size_t set) const { return timesOf(losses_[set].middle); }

  /// At the largest depths that its rounding allows.
  LossTimes earliest(std::size_t set) const { return timesOf(worst(losses_[set])); }

  /// At the smallest.
  LossTimes latest(std::size_t set) const;

  /// Which eyes have had a sign of a set in sight. Those that have not count as lost at the first
  /// time.
  std::vector<bool> inSight(std::size_t set) const;

  /// Which of them had none at the first time.
  std::vector<bool> inSightLater(std::size_t set) const;

 private:
  /// Positions in times_.
  struct Loss {
    std::uint64_t down : 21 = kNever, up : 21 = kNever, known : 21 = kAlways;
    std::uint64_t begun : 1 = 0;  // a sign has been in sight
    double none = std::numeric_limits<double>::infinity();

    // Both are the same time: infinite.
    static constexpr std::uint64_t kNever = 0, kAlways = 0, kNeverKnown = 1;
  };

  struct Set {
    std::vector<std::size_t> members;
    double factor = 1;
    bool hasBest = true;
    std::vector<Loss> middle = {}, worst = {}, best = {};  // the last two: where bounds differ
    std::vector<bool> first = {};  // which had a sign in sight at the first time
  };

  static const std::vector<Loss>& worst(const Set& set) {
    return set.worst.empty() ? set.middle : set.worst;
  }

  LossTimes timesOf(const std::vector<Loss>& losses) const;
  void splitBounds();
  void updateEye(std::size_t eye, std::span<const Sighting> sightings);

  std::size_t eyes_;
  std::size_t signs_;
  std::vector<Set> losses_;
  std::vector<double> times_;  // infinity, -infinity, and those of update()

  // Of each line at the time before, shape (sign, eye). The depth of lines on which the smoke is
  // not known everywhere is what is known of it.
  std::vector<double> depth_;
  std::vector<float> low_, high_;     // rounded outwards; empty: as depth_
  std::vector<unsigned char> state_;  // kOpen, kCovered
  std::uint64_t last_ = 0;            // the time before
  bool begun_ = false;
};

}  // namespace volute
