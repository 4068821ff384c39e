// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

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
  double limit = 0;      ///< in the quantity's unit; of doses and fractions dimensionless
  bool falling = false;  ///< reached from above, as oxygen's
  std::string source;    ///< of the limit
  bool checked = false;  ///< the source of the limit was read, not quoted from memory

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

/// The criteria that are looked at when none are named.
const std::vector<Criterion>& usualCriteria();

}  // namespace volute
