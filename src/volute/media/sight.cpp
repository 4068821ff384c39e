// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/sight.hpp"

#include <map>
#include <tuple>

#include "volute/base/assert.hpp"

namespace volute {

std::optional<StoredPlace> storedPlace(std::span<const double> times, double time) {
  constexpr double kSame = 1e-6;    // relative, or [s] near 0
  constexpr double kBeyond = 0.05;  // of an interval
  const std::size_t last = times.size() - 1;
  const double same = kSame * std::max(1.0, std::abs(time));
  const auto end = [&](std::size_t i) { return StoredPlace{i, i, 0, {times[i], times[i]}}; };
  if (time <= times.front()) {
    const double beyond = last > 0 ? kBeyond * (times[1] - times[0]) : 0;
    return times.front() - time <= std::max(beyond, same) ? std::optional(end(0)) : std::nullopt;
  }
  if (time >= times.back()) {
    const double beyond = last > 0 ? kBeyond * (times[last] - times[last - 1]) : 0;
    return time - times.back() <= std::max(beyond, same) ? std::optional(end(last)) : std::nullopt;
  }
  const auto second =
      static_cast<std::size_t>(std::ranges::upper_bound(times, time) - times.begin());
  const std::size_t first = second - 1;
  if (times[first] == time)
    return end(first);
  const double share = (time - times[first]) / (times[second] - times[first]);
  return StoredPlace{first, second, share, {times[first], times[second]}};
}

bool isStored(std::span<const double> times, double time) {
  constexpr double kSame = 0.05;  // of an interval, as storedPlace() has it
  const auto place = storedPlace(times, time);
  return place && (place->share <= kSame || place->share >= 1 - kSame);
}

double spacingAt(std::span<const double> times, double time) {
  if (times.size() < 2)
    return std::numeric_limits<double>::infinity();
  constexpr std::size_t kLevelled = 2;  // intervals on each side
  const std::size_t last = times.size() - 1;
  const auto after = std::ranges::upper_bound(times.begin() + 1, times.end() - 1, time);
  const auto second = static_cast<std::size_t>(after - times.begin()), first = second - 1;
  double own = times[second] - times[first];
  if (times[first] == time && first > 0)
    own = std::min(own, times[first] - times[first - 1]);
  const std::size_t from = first - std::min(first, kLevelled);
  const std::size_t until = std::min(second + kLevelled, last);
  const double mean = (times[until] - times[from]) / static_cast<double>(until - from);
  return std::max(own, mean) < kFinerTimes * std::min(own, mean) ? mean : own;
}

Status PointField::answer(double time, std::span<const Vec3> points, std::span<PointValue> out) {
  std::vector<double> values(points.size(), std::numeric_limits<double>::quiet_NaN());
  const auto place = storedPlace(times(), time);
  if (place)
    VOLUTE_TRY(at(time, points, values));
  for (std::size_t i = 0; i < points.size(); ++i)
    out[i] = {values[i], values[i], values[i], place ? place->span : out[i].span};
  return {};
}

Status PointField::valuesOf(double time, std::span<const Vec3> points, std::span<double> out) {
  std::vector<PointValue> values(points.size());
  VOLUTE_TRY(answer(time, points, values));
  std::ranges::transform(values, out.begin(), &PointValue::value);
  return {};
}

std::vector<ServedSource> PointField::sources() const {
  return {{description(), times().size(), {times().front(), times().back()}, std::nullopt}};
}

BestPoints::BestPoints(std::vector<std::unique_ptr<PointField>> sources,
                       std::vector<std::string> unread)
    : sources_(std::move(sources)), unread_(std::move(unread)), served_(sources_.size()) {
  VOLUTE_ASSERT(!sources_.empty());
  for (const auto& source : sources_)
    times_.insert(times_.end(), source->times().begin(), source->times().end());
  std::ranges::sort(times_);
  times_.erase(std::ranges::unique(times_).begin(), times_.end());
}

std::string BestPoints::description() const {
  std::string all;
  for (const auto& source : sources_) all += (all.empty() ? "" : ", else ") + source->description();
  return all;
}

bool BestPoints::isExact() const {
  return std::ranges::all_of(sources_, [](const auto& source) { return source->isExact(); });
}

namespace {

/// Bounds within both; false: the other's do not narrow them, or contradict them.
bool narrow(PointValue& one, const PointValue& by) {
  const double low = std::max(one.low, by.low), high = std::min(one.high, by.high);
  if (!by.ofPlace || !(low <= high) || (low == one.low && high == one.high))
    return false;
  one.low = low;
  one.high = high;
  one.value = std::clamp(one.value, low, high);
  return true;
}

}  // namespace

/// What a source says at a time, of as many points as were asked.
struct BestPoints::Said {
  double apart = 0;     ///< its times, around this one [s]
  bool beyond = false;  ///< known by what is allowed beyond its ends alone
  bool stored = false;
  StoredSpan span{};  ///< its stored times around
  std::vector<PointValue> values{};

  bool knows(std::size_t point) const {
    return !values.empty() && !std::isnan(values[point].value);
  }

  /// Whether its times are about as close together as those that are closest.
  bool isAlike(const Said& closest) const {
    return beyond == closest.beyond &&
           (apart == closest.apart || apart < kFinerTimes * closest.apart);
  }
};

/// Asks sources of one time. Where several of them that know a place can change its bounds,
/// `between` is given the stored times of any of these around, else twice `time`.
Status BestPoints::choose(double time, std::span<const Vec3> points, std::span<PointValue> out,
                          std::span<StoredSpan> between) {
  constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
  std::vector<Said> said(sources_.size());
  std::vector<std::size_t> order;
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    const auto times = sources_[s]->times();
    const auto place = storedPlace(times, time);
    if (!place)
      continue;
    said[s] = {.apart = spacingAt(times, time),
               .beyond = time < times.front() || time > times.back(),
               .stored = isStored(times, time),
               .span = place->span};
    order.push_back(s);
  }
  std::ranges::sort(
      order, {}, [&](std::size_t s) { return std::make_tuple(said[s].beyond, said[s].apart, s); });
  // Those that know each point: the closest, and the first of those like it.
  std::vector<std::size_t> closest(points.size(), kNone), best(points.size(), kNone);
  for (const std::size_t s : order) {
    Said& one = said[s];
    std::vector<std::size_t> open;
    std::vector<Vec3> at;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (closest[i] != kNone) {
        const PointValue& known = said[best[i]].values[i];
        const bool before = s < best[i] && one.isAlike(said[closest[i]]);
        if (!before && (one.beyond || !(known.low < known.high)))
          continue;
      }
      open.push_back(i);
      at.push_back(points[i]);
    }
    if (open.empty())
      continue;
    std::vector<PointValue> values(at.size());
    VOLUTE_TRY(sources_[s]->answer(time, at, values));
    one.values.resize(points.size());
    for (std::size_t k = 0; k < open.size(); ++k) {
      const std::size_t i = open[k];
      one.values[i] = values[k];
      if (!one.knows(i))
        continue;
      if (closest[i] == kNone)
        closest[i] = best[i] = s;
      else if (s < best[i] && one.isAlike(said[closest[i]]))
        best[i] = s;
    }
  }
  std::vector<char> took(sources_.size(), 0);
  for (std::size_t i = 0; i < points.size(); ++i) {
    between[i] = {time, time};
    if (best[i] == kNone) {
      out[i] = {.span = out[i].span};
      continue;
    }
    out[i] = said[best[i]].values[i];
    took[best[i]] = 1;
    if (!(out[i].low < out[i].high) || said[best[i]].beyond)
      continue;
    StoredSpan around = said[best[i]].span;
    bool several = false;
    for (std::size_t s = 0; s < said.size(); ++s) {
      if (s == best[i] || !said[s].knows(i) || said[s].beyond)
        continue;
      several = true;
      around = {std::max(around.from, said[s].span.from),
                std::min(around.until, said[s].span.until)};
      if ((said[s].stored || said[s].isAlike(said[closest[i]])) &&
          narrow(out[i], said[s].values[i]))
        took[s] = 1;
    }
    if (several)
      between[i] = around;
  }
  for (std::size_t s = 0; s < said.size(); ++s) {
    auto& served = served_[s];
    if (took[s] != 0) {
      served = served ? StoredSpan{std::min(served->from, time), std::max(served->until, time)}
                      : StoredSpan{time, time};
    }
  }
  return {};
}

Status BestPoints::answer(double time, std::span<const Vec3> points, std::span<PointValue> out) {
  std::vector<StoredSpan> between(points.size());
  VOLUTE_TRY(choose(time, points, out, between));
  // What several leave open together is linear between their stored times, as each of them is, so
  // that it does not matter who asks at which times.
  std::map<std::pair<double, double>, std::vector<std::size_t>> groups;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (between[i].from < between[i].until)
      groups[{between[i].from, between[i].until}].push_back(i);
  }
  for (const auto& [ends, group] : groups) {
    std::vector<Vec3> at;
    for (const std::size_t i : group) at.push_back(points[i]);
    std::vector<PointValue> before(at.size()), after(at.size());
    between.resize(at.size());
    VOLUTE_TRY(choose(ends.first, at, before, between));
    VOLUTE_TRY(choose(ends.second, at, after, between));
    const double share = (time - ends.first) / (ends.second - ends.first);
    for (std::size_t k = 0; k < group.size(); ++k) {
      if (std::isnan(before[k].value) || std::isnan(after[k].value))
        continue;
      PointValue& one = out[group[k]];
      for (const auto part : {&PointValue::value, &PointValue::low, &PointValue::high})
        one.*part = (1 - share) * before[k].*part + share * after[k].*part;
      one.span = {std::min(before[k].span.from, after[k].span.from),
                  std::max(before[k].span.until, after[k].span.until)};
    }
  }
  return {};
}

std::vector<ServedSource> BestPoints::sources() const {
  std::vector<ServedSource> all;
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    for (ServedSource& one : sources_[s]->sources()) {
      one.served = served_[s];
      all.push_back(std::move(one));
    }
  }
  for (const std::string& why : unread_) all.push_back({why, 0, {}, std::nullopt});
  return all;
}

}  // namespace volute
