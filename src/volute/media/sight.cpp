// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/sight.hpp"

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

Status BestPoints::answer(double time, std::span<const Vec3> points, std::span<PointValue> out) {
  for (PointValue& one : out) one = {.span = one.span};
  // Sources that know this time, with how far their times are apart there. Those that do by what is
  // allowed beyond their ends come last.
  std::vector<std::tuple<bool, double, std::size_t>> order;
  double closest = std::numeric_limits<double>::infinity();
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    const auto times = sources_[s]->times();
    const auto place = storedPlace(times, time);
    if (!place)
      continue;
    const std::size_t second = std::max<std::size_t>(place->second, 1);
    const double apart = times.size() > 1 ? times[second] - times[second - 1]
                                          : std::numeric_limits<double>::infinity();
    closest = std::min(closest, apart);
    order.emplace_back(time < times.front() || time > times.back(), apart, s);
  }
  if (order.empty())
    return {};
  for (auto& [beyond, apart, s] : order)  // by powers of two of the closest
    apart = std::isinf(closest) ? 0 : std::floor(std::log2(apart / closest));
  std::ranges::sort(order);
  for (const auto& [beyond, apart, s] : order) {
    PointField& source = *sources_[s];
    bool any = false;
    if (&s == &std::get<2>(order.front())) {
      VOLUTE_TRY(source.answer(time, points, out));
      any = std::ranges::any_of(out, [](const PointValue& one) { return !std::isnan(one.value); });
    } else {
      const bool narrows =
          !beyond && (apart == std::get<1>(order.front()) || isStored(source.times(), time));
      std::vector<std::size_t> open;
      std::vector<Vec3> at;
      for (std::size_t i = 0; i < points.size(); ++i) {
        if (!std::isnan(out[i].value) && !(narrows && out[i].low < out[i].high))
          continue;
        open.push_back(i);
        at.push_back(points[i]);
      }
      if (open.empty())
        continue;
      std::vector<PointValue> values(at.size());
      VOLUTE_TRY(source.answer(time, at, values));
      for (std::size_t k = 0; k < open.size(); ++k) {
        if (std::isnan(values[k].value))
          continue;
        if (std::isnan(out[open[k]].value)) {
          out[open[k]] = values[k];
          any = true;
        } else if (narrow(out[open[k]], values[k])) {
          any = true;
        }
      }
    }
    if (any) {
      auto& served = served_[s];
      served = served ? StoredSpan{std::min(served->from, time), std::max(served->until, time)}
                      : StoredSpan{time, time};
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
