// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>
#include <string>
#include <vector>

#include "volute/math/vec.hpp"
#include "volute/report/json.hpp"
#include "volute/visibility/loss.hpp"

// The verdict at the top of a report.

namespace volute {

/// The first of many places at which something is lost.
struct FirstLoss {
  bool any = false;
  std::size_t place = 0;
  double down = 0, none = 0, up = 0;  ///< [s]
  double share = 0;                   ///< of the places that lose it until the end

  /// Until when it is certain that nothing is lost anywhere [s], where the first loss is not:
  /// some place is not known from then on. Infinite: the answer is certain; -infinite: some place
  /// is never known. A loss that is there is one that comes at the latest then.
  double known = std::numeric_limits<double>::infinity();
  double unknown = 0;  ///< share of the places that are not known all along

  bool certain() const { return known > 0 && std::isinf(known); }

  double by(RoundTime round) const {
    return round == RoundTime::kDown ? down : (round == RoundTime::kUp ? up : none);
  }
};

/// LossTimes::known as results state it: true (known all along), false (never), or until when [s].
Json knownJson(double known);

struct FirstLoss;

/// When the first loss comes by the least that the data allow; null: not certain, or never.
Json latestJson(const FirstLoss& latest, RoundTime round);

/// Among the places for which `counts` is true; empty: all.
FirstLoss firstLoss(const LossTimes& times, RoundTime round, const std::vector<bool>& counts = {});

/// The first loss among some places.
FirstLoss firstLoss(const LossTimes& times, RoundTime round, std::span<const std::size_t> places);

/// Losses, and the places at which they count; null: all.
struct CountedLoss {
  const LossTimes* times;
  const std::vector<bool>* counts = nullptr;
};

/// The first of several losses at each place, compared by what is the best guess of each. What is
/// not known of one matters unless another one comes before.
/// @param which  null, or of each place which of them that is; -1: none
LossTimes firstOf(std::span<const CountedLoss> all, RoundTime round,
                  std::vector<int>* which = nullptr);

/// "12.6 s (between 12 and 24 s) at x, y, z".
std::string timeWords(const FirstLoss& loss, RoundTime round);

/// What is added to a verdict of the largest smoke that rounding, caps and means of the files
/// allow, where that of the least comes later than its times; else empty. `reached` as in
/// unknownWords().
std::string latestWords(const FirstLoss& first, const FirstLoss& latest, std::string_view reached);
std::string placeWords(const Vec3& place);
std::string percentWords(double share);  ///< "12 %", "less than 1 %"

/// "it is not known anywhere", "not reached by 14 s, not known after at 12 % of the floor": of a
/// loss that is not certain. `reached` is "reached" or "lost".
std::string unknownWords(const FirstLoss& loss, std::string_view reached, std::string_view places);

/// {criterion, sentence, time, known, time_interpolated, time_down, time_up, at_the_latest,
/// position, share, share_not_known}: `time` is null where it is not certain.
Json verdictJson(const std::string& criterion, const std::string& sentence, const FirstLoss& loss,
                 RoundTime round, std::span<const Vec3> places);

}  // namespace volute
