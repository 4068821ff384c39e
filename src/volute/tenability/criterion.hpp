// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "volute/tenability/dose.hpp"

namespace volute {

/// When conditions count as untenable: a quantity, a dose or a fraction that reaches a limit.
struct Criterion {
  std::string name;
  std::optional<DoseLaw> law;  ///< a dose or a fraction; else the quantity itself
  Air quantity = Air::kTemperature;
  DosePerson person;
  double limit = 0;       ///< in the quantity's unit; of doses and fractions dimensionless
  bool falling = false;   ///< reached from above, as oxygen's
  std::string source;     ///< of the limit
  bool checked = false;   ///< the source of the limit was read, not quoted from memory
  std::string applies{};  ///< where or to whom, in words; empty: to all

  /// Floor areas of the rooms for which it is [m2]: roomFrom <= area < roomBelow.
  double roomFrom = 0;
  double roomBelow = std::numeric_limits<double>::infinity();

  /// Whether it is for a room of this floor area [m2]; NaN: where no room is known, which is taken
  /// for a large one.
  bool isForRoom(double area) const {
    return area >= roomFrom ? area < roomBelow : !(area < roomFrom) && roomBelow > 1e300;
  }

  /// Whether values are integrated over time.
  bool isDose() const { return law && !isInstantaneous(*law); }

  std::string unit() const;

  /// "temperature >= 60 degrees C"
  std::string words() const;

  /// What is compared with the limit, or of a dose its rate [1/s]. NaN: not known.
  double value(const Exposure& air) const;

  std::vector<Air> needed() const;
  std::vector<Air> taken() const;

  /// False where the case stores too little: `stored(Air)`.
  template <class Stored>
  bool assessable(Stored&& stored) const {
    const auto all = needed();
    if (law && isInstantaneous(*law)) {
      for (const Air air : all) {
        if (stored(air))
          return true;
      }
      return false;
    }
    for (const Air air : all) {
      if (!stored(air))
        return false;
    }
    return true;
  }
};

/// Criteria that belong together.
struct CriteriaProfile {
  std::string name;      ///< "nz-c4.3"
  std::string title;     ///< for people
  std::string citation;  ///< where they are from, and what of it was read
  std::string applies;   ///< where they hold, and at which height
  std::vector<Criterion> criteria;
};

/// The first are those that are looked at when none are named.
std::span<const CriteriaProfile> criteriaProfiles();

const std::vector<Criterion>& usualCriteria();

}  // namespace volute
