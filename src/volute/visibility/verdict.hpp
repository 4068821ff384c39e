// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>
#include <string>
#include <vector>

#include "volute/math/vec.hpp"
#include "volute/report/json.hpp"
#include "volute/visibility/loss.hpp"

// What a report says first.

namespace volute {

/// The first of many places at which something is lost.
struct FirstLoss {
  bool any = false;
  std::size_t place = 0;
  double down = 0, none = 0, up = 0;  ///< [s]
  double share = 0;                   ///< of the places that lose it until the end

  double by(RoundTime round) const {
    return round == RoundTime::kDown ? down : (round == RoundTime::kUp ? up : none);
  }
};

/// Among the places for which `counts` is true; empty: all.
FirstLoss firstLoss(const LossTimes& times, RoundTime round, const std::vector<bool>& counts = {});

/// "12.6 s (between 12 and 24 s) at x, y, z".
std::string timeWords(const FirstLoss& loss);
std::string placeWords(const Vec3& place);

/// {criterion, sentence, time, time_interpolated, time_down, time_up, position, share}.
Json verdictJson(const std::string& criterion, const std::string& sentence, const FirstLoss& loss,
                 RoundTime round, std::span<const Vec3> places);

}  // namespace volute
