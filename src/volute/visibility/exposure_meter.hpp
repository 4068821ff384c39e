// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "volute/media/sight.hpp"
#include "volute/tenability/criterion.hpp"
#include "volute/visibility/loss.hpp"

namespace volute {

/// The air of a case, quantity by quantity, as far as it is stored.
class AirField {
 public:
  /// Opens what `criteria` need or take in. What is not stored is a sentence of gaps(), no error;
  /// what is and cannot be read is there, and unknown at all times. The extinction comes from
  /// whoever asks.
  /// @param smokeFrom  when the smoke is looked at first [s]
  static AirField open(SightField& field, std::span<const Criterion> criteria,
                       double smokeFrom = -std::numeric_limits<double>::infinity());

  bool has(Air air) const { return air == Air::kExtinction || fields_[index(air)] != nullptr; }

  /// Why a quantity is not there; empty for those that are, or that nobody asked for.
  const std::string& gap(Air air) const { return gaps_[index(air)]; }

  /// Where a quantity comes from; empty for those that are not there.
  std::string description(Air air) const;

  /// The sources of a quantity, and what they have served.
  std::vector<ServedSource> sources(Air air) const;

  /// Why some of what a case stores of a quantity cannot be read; empty: all of it can.
  std::string unread(Air air) const;

  /// Stored times of any quantity after `from` and before `to` [s], ascending.
  std::vector<double> timesBetween(double from, double to) const;

  /// When the case begins [s], by all that is known of it.
  double begin() const { return begin_; }

  /// Until when anything of it is stored [s]; -infinite: nothing is.
  double end() const { return end_; }

  /// Whether the case begins before the smoke is stored, or looked at.
  bool smokeIsLate() const { return smokeIsLate_; }

  /// The stored times around another one, of each quantity.
  using Spans = std::array<StoredSpan, kAirQuantities>;

  /// Bounds of the air's quantities around a point.
  struct Around {
    Exposure worst = unknown(), least = unknown();  ///< of all quantities at once
    Spans spans{};                                  ///< from which times each value comes
  };

  /// An exposure of which nothing is known: all NaN.
  static Exposure unknown();

  /// Whether the quantities of a criterion have no uncertainty.
  bool isExact(const Criterion& criterion) const;

  /// The air at points. Quantities that are not stored there and then are NaN; those that the case
  /// does not store at all, and the extinction, stay as they are, as in unknown().
  /// @param around  empty: not asked for
  [[nodiscard]] Status at(double time, std::span<const Vec3> points, std::span<Exposure> out,
                          std::span<Around> around = {});

 private:
  static std::size_t index(Air air) { return static_cast<std::size_t>(air); }

  std::array<std::unique_ptr<PointField>, kAirQuantities> fields_;
  std::array<std::string, kAirQuantities> gaps_;
  double begin_ = std::numeric_limits<double>::infinity();
  double end_ = -std::numeric_limits<double>::infinity();
  bool smokeIsLate_ = false;
};

/// From one value to another, of which one may be infinite.
inline double mixed(double one, double other, double share) {
  return share <= 0 ? one : share >= 1 ? other : (1 - share) * one + share * other;
}

/// The exposure of people who stay or move: cumulative doses, levels, and the time when each
/// reaches its limit. Between two times at which the air is known, rates of dose are linear. While
/// it is not known a dose does not grow, and is a lower bound from then on; so it is where
/// something that a law takes in besides what it needs is stored, but not there and then.
class ExposureMeter {
 public:
  /// Criteria that the air cannot answer are left out; missing() names them.
  /// @param rooms  whether whoever asks knows rooms; else criteria for small ones are missing
  ExposureMeter(AirField air, std::span<const Criterion> criteria, std::size_t people,
                bool rooms = false);

  /// [bytes] that are kept of each person: what follows the criteria, twice where values leave
  /// something open, and the air of a time.
  static std::uint64_t bytesOfPerson(const AirField& air, std::span<const Criterion> criteria,
                                     bool rooms = false);

  struct Missing {
    Criterion criterion;
    std::string why;
  };

  const std::vector<Criterion>& criteria() const { return criteria_; }

  const std::vector<Missing>& missing() const { return missing_; }

  /// Quantities of a criterion that the case does not store: taken as in clean air.
  std::vector<Air> assumed(std::size_t criterion) const;

  const AirField& air() const { return air_; }

  /// Whether anything is known of a criterion, anywhere at any time, or would be if all files could
  /// be read; else it is not assessed at these places.
  bool isAssessed(std::size_t criterion) const;

  /// Why files of what a criterion takes in cannot be read; empty: they can.
  std::string unread(std::size_t criterion) const;

  /// Where people are at a time; NaN: not there.
  using Places = std::function<void(double time, std::span<Vec3> places)>;

  /// Nothing is known of somebody who is there before the first time, or stays beyond the last one.
  void lose(std::size_t person);

  /// The extinction where people are [1/m]: the most and the least that the data allow.
  struct Smoke {
    std::span<const double> most;   ///< empty: not known
    std::span<const double> least;  ///< empty: nobody asks for latest() of criteria of the smoke
  };

  /// The same at a time between two at which it is given; `least` may be empty.
  using SmokeBetween =
      std::function<void(double time, std::span<double> most, std::span<double> least)>;

  /// When somebody comes or goes [s].
  struct Turn {
    double time = 0;
    std::size_t person = 0;
  };

  /// Goes on to `time` [s], through the stored times between and in steps of at most `step`.
  /// @param smoke  at the places at `time`; where it is not known, its criteria wait.
  /// @param between  null: criteria of the smoke wait for `time`
  /// @param turns  ascending, of any times: doses begin and end there, not at the next of the
  /// others
  [[nodiscard]] Status advance(double time, const Places& places, const Smoke& smoke = {},
                               double step = std::numeric_limits<double>::infinity(),
                               const SmokeBetween& between = nullptr,
                               std::span<const Turn> turns = {});

  /// From now on nothing is known of the smoke.
  void loseSmoke();

  /// When a criterion is reached by the least that the data allow, of the smoke or by what means of
  /// cells leave open. Null where that is times().
  const LossTimes* latest(std::size_t criterion) const;

  /// Doses so far, or levels at the last time; NaN where nothing is known. Of doses that are not
  /// known(), lower bounds.
  std::span<const double> values(std::size_t criterion) const { return means_[criterion].values; }

  /// The largest value so far.
  std::span<const double> worst(std::size_t criterion) const { return means_[criterion].worst; }

  /// The same by the worst that the data allow, which times() are of; empty where that is worst().
  std::span<const double> worstAllowed(std::size_t criterion) const {
    return most_[criterion].worst;
  }

  /// values() by the worst that the data allow; empty where that is values().
  std::span<const double> valuesAllowed(std::size_t criterion) const {
    return most_[criterion].values;
  }

  const LossTimes& times(std::size_t criterion) const { return watches_[criterion].times(); }

  /// Whether somebody's criterion could not be followed all along: the air was not known there at
  /// some time.
  bool unknown(std::size_t criterion, std::size_t person) const {
    return unknown_[criterion][person];
  }

 private:
  bool hasLeast(std::size_t criterion) const;
  Status sample(double time, const Places& places, const Smoke& smoke,
                std::span<const Turn> alone = {});

  /// What a criterion goes by, of each person: the level or the dose so far, the last rate, and the
  /// worst so far.
  struct Course {
    std::vector<double> values, rates, worst;

    explicit Course(std::size_t people);

    bool empty() const { return values.empty(); }
  };

  AirField air_;
  std::vector<Criterion> criteria_;
  std::vector<Missing> missing_;
  // Of each criterion: by the values, and by the worst and the least that they leave open, which
  // are empty where they leave nothing open.
  std::vector<Course> means_, most_, fewest_;
  std::size_t people_;
  bool begun_ = false;
  bool begunSmoke_ = false;  // advance() was there
  StoredSpan smokeSpan_;     // of the last two times at which the smoke is known
  double last_ = 0;
  std::vector<std::vector<char>> unknown_;
  std::vector<char> there_;      // at the last time
  std::vector<double> since_;    // that of each
  std::vector<Exposure> inAir_;  // of those who are there, as far as it is stored
  std::vector<AirField::Around> around_;
  std::vector<LevelWatch> watches_;
  std::vector<LevelWatch> least_;  // of each criterion; without places where nothing is open
  bool tookLeast_ = false;
};

}  // namespace volute
