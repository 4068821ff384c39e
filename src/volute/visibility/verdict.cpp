// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/verdict.hpp"

#include <fmt/format.h>

#include <cmath>

namespace volute {

FirstLoss firstLoss(const LossTimes& times, RoundTime round, const std::vector<bool>& counts) {
  FirstLoss first;
  std::size_t considered = 0, lost = 0;
  const std::vector<double>& by = times.by(round);
  for (std::size_t i = 0; i < by.size(); ++i) {
    if (!counts.empty() && !counts[i])
      continue;
    ++considered;
    if (std::isinf(times.up[i]))
      continue;
    ++lost;
    const bool sooner = by[i] < by[first.place] ||
                        (by[i] == by[first.place] && times.none[i] < times.none[first.place]);
    if (!first.any || sooner)
      first.place = i;
    first.any = true;
  }
  if (first.any) {
    first.down = times.down[first.place];
    first.none = times.none[first.place];
    first.up = times.up[first.place];
  }
  first.share = considered > 0 ? static_cast<double>(lost) / static_cast<double>(considered) : 0;
  return first;
}

std::string timeWords(const FirstLoss& loss) {
  if (loss.down == loss.up)
    return fmt::format("{:.4g} s", loss.none);
  return fmt::format("{:.4g} s (between {:.4g} and {:.4g} s, interpolated {:.3g} s)", loss.down,
                     loss.down, loss.up, loss.none);
}

std::string placeWords(const Vec3& place) {
  return fmt::format("x = {:.3g}, y = {:.3g}, z = {:.3g} m", place[0], place[1], place[2]);
}

Json verdictJson(const std::string& criterion, const std::string& sentence, const FirstLoss& loss,
                 RoundTime round, std::span<const Vec3> places) {
  Json json = {{"criterion", criterion}, {"sentence", sentence}, {"time", nullptr}};
  if (!loss.any)
    return json;
  const Vec3& place = places[loss.place];
  json["time"] = jsonNumber(loss.by(round));
  json["time_down"] = jsonNumber(loss.down);
  json["time_interpolated"] = jsonNumber(loss.none);
  json["time_up"] = jsonNumber(loss.up);
  json["position"] = {place[0], place[1], place[2]};
  json["share"] = loss.share;
  return json;
}

}  // namespace volute
