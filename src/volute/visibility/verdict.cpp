// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/verdict.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "volute/base/plain_number.hpp"

namespace volute {

Json knownJson(double known) {
  return std::isinf(known) ? Json(known > 0) : Json(known);
}

Json latestJson(const FirstLoss& latest, RoundTime round) {
  return latest.any && latest.certain() ? jsonNumber(latest.by(round)) : Json();
}

FirstLoss firstLoss(const LossTimes& times, RoundTime round, const std::vector<bool>& counts) {
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < times.up.size(); ++i) {
    if (counts.empty() || counts[i])
      places.push_back(i);
  }
  return firstLoss(times, round, places);
}

FirstLoss firstLoss(const LossTimes& times, RoundTime round, std::span<const std::size_t> places) {
  constexpr double kAlways = std::numeric_limits<double>::infinity();
  FirstLoss first, latest;  // among places that are known, and of the others
  std::size_t lost = 0, unknown = 0;
  double known = kAlways;
  const std::vector<double>& by = times.by(round);
  for (const std::size_t i : places) {
    const bool complete = times.complete(i);
    unknown += !complete;
    if (!complete)
      known = std::min(known, times.known[i]);
    if (std::isinf(times.up[i]))
      continue;
    ++lost;
    FirstLoss& one = complete ? first : latest;
    const bool sooner =
        by[i] < by[one.place] || (by[i] == by[one.place] && times.none[i] < times.none[one.place]);
    if (!one.any || sooner)
      one.place = i;
    one.any = true;
  }
  const bool certain = known == kAlways || (first.any && by[first.place] <= known);
  if (!certain && latest.any && (!first.any || by[latest.place] < by[first.place]))
    first = latest;
  first.known = certain ? kAlways : known;
  if (first.any) {
    first.down = times.down[first.place];
    first.none = times.none[first.place];
    first.up = times.up[first.place];
  }
  if (!places.empty()) {
    const auto all = static_cast<double>(places.size());
    first.share = static_cast<double>(lost) / all;
    first.unknown = static_cast<double>(unknown) / all;
  }
  return first;
}

LossTimes firstOf(std::span<const CountedLoss> all, RoundTime round, std::vector<int>* which) {
  const std::size_t places = all.empty() ? 0 : all.front().times->up.size();
  LossTimes first(places);
  if (which != nullptr)
    which->assign(places, -1);
  const auto counts = [](const CountedLoss& one, std::size_t place) {
    return one.counts == nullptr || (*one.counts)[place];
  };
  for (std::size_t i = 0; i < places; ++i) {
    const auto addThose = [&](bool complete) {
      for (std::size_t n = 0; n < all.size(); ++n) {
        const LossTimes& times = *all[n].times;
        if (!counts(all[n], i) || times.complete(i) != complete)
          continue;
        if (times.none[i] < first.none[i] && which != nullptr)
          (*which)[i] = static_cast<int>(n);
        first.down[i] = std::min(first.down[i], times.down[i]);
        first.none[i] = std::min(first.none[i], times.none[i]);
        first.up[i] = std::min(first.up[i], times.up[i]);
      }
    };
    addThose(true);
    for (const CountedLoss& one : all) {
      if (counts(one, i) && !one.times->complete(i) && one.times->known[i] < first.by(round)[i])
        first.lose(i, one.times->known[i]);
    }
    if (!first.complete(i))
      addThose(false);
  }
  return first;
}

std::string percentWords(double share) {
  const double percent = 100 * share;
  return share > 0 && percent < 0.5    ? "less than 1 %"
         : share < 1 && percent > 99.5 ? "more than 99 %"
                                       : fmt::format("{:.0f} %", percent);
}

std::string unknownWords(const FirstLoss& loss, std::string_view reached, std::string_view places) {
  const std::string where = fmt::format("{} of {}", percentWords(loss.unknown), places);
  if (std::isinf(loss.known))
    return fmt::format("not known at {}", where);
  return fmt::format("not {} by {} s, and not known after that at {}", reached,
                     plainNumber(loss.known, 4), where);
}

std::string timeWords(const FirstLoss& loss, RoundTime round) {
  if (loss.down == loss.up)
    return fmt::format("{} s", plainNumber(loss.none, 4));
  const double whole = std::max(1.0, std::round(loss.none));  // of long fires all seconds
  return fmt::format("{} s (between {} and {} s, interpolated {} s)",
                     plainNumber(loss.by(round), 4), plainNumber(loss.down, 4),
                     plainNumber(loss.up, 4),
                     whole < 1000 ? fmt::format("{:.3g}", loss.none) : fmt::format("{:g}", whole));
}

std::string latestWords(const FirstLoss& first, const FirstLoss& latest, std::string_view reached) {
  if (!first.certain() || !first.any || (latest.any && latest.down <= first.up))
    return "";
  const std::string by = latest.any
                             ? fmt::format("first {} at {} s", reached, plainNumber(latest.none, 4))
                             : fmt::format("perhaps never {}", reached);
  return fmt::format(
      " This is by the worst air that rounding, caps and means at nodes allow; by the least it is "
      "{}.",
      by);
}

std::string placeWords(const Vec3& place) {
  // Three digits, and tenths of metres where they are far from the origin.
  const auto text = [](double value) {
    return std::abs(value) < 100 ? fmt::format("{:.3g}", value)
                                 : fmt::format("{:.10g}", std::round(10 * value) / 10);
  };
  return fmt::format("x = {}, y = {}, z = {} m", text(place[0]), text(place[1]), text(place[2]));
}

Json verdictJson(const std::string& criterion, const std::string& sentence, const FirstLoss& loss,
                 RoundTime round, std::span<const Vec3> places) {
  Json json = {{"criterion", criterion},
               {"sentence", sentence},
               {"time", nullptr},
               {"known", knownJson(loss.known)}};
  if (loss.unknown > 0)
    json["share_not_known"] = loss.unknown;
  if (!loss.any)
    return json;
  const Vec3& place = places[loss.place];
  if (loss.certain()) {
    json["time"] = jsonNumber(loss.by(round));
    json["time_down"] = jsonNumber(loss.down);
    json["time_interpolated"] = jsonNumber(loss.none);
    json["time_up"] = jsonNumber(loss.up);
  } else {
    json["at_the_latest"] = jsonNumber(loss.up);
  }
  json["position"] = {place[0], place[1], place[2]};
  json["share"] = loss.share;
  return json;
}

}  // namespace volute
