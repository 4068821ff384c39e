// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/loss.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "volute/base/assert.hpp"
#include "volute/base/parallel.hpp"

namespace volute {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

// What stands between an eye and a sign.
constexpr unsigned char kOpen = 1, kCovered = 2;

/// A part of the way from one time to the next, 0 to 1; none where begin > end.
struct Span {
  double begin = 1, end = 0;
};

/// Where a depth that goes from `a` to `b` is at most `limit`.
Span atMost(double limit, double a, double b) {
  const bool first = a <= limit, last = b <= limit;
  if (first && last)
    return {0, 1};
  if (!first && !last)
    return {};
  double share = (limit - a) / (b - a);
  if (!(share >= 0 && share <= 1))  // one of them is infinite, or not known
    share = first ? 0 : 1;
  return first ? Span{0, share} : Span{share, 1};
}

}  // namespace

Result<RoundTime> roundTime(std::string_view name) {
  for (const RoundTime round : {RoundTime::kDown, RoundTime::kNone, RoundTime::kUp}) {
    if (nameOf(round) == name)
      return round;
  }
  return fail(ErrorCode::kInvalidArgument, "rounding '{}': expected down, none or up", name);
}

std::string_view nameOf(RoundTime round) {
  return round == RoundTime::kDown ? "down" : (round == RoundTime::kUp ? "up" : "none");
}

LossTimes::LossTimes(std::size_t places)
    : down(places, kNever), none(down), up(down), known(down) {}

const std::vector<double>& LossTimes::by(RoundTime round) const {
  return round == RoundTime::kDown ? down : (round == RoundTime::kUp ? up : none);
}

double LossTimes::answer(std::size_t place, RoundTime round) const {
  return complete(place) ? by(round)[place] : std::numeric_limits<double>::quiet_NaN();
}

std::vector<double> LossTimes::answers(RoundTime round) const {
  std::vector<double> times(known.size());
  for (std::size_t i = 0; i < times.size(); ++i) times[i] = answer(i, round);
  return times;
}

LevelWatch::LevelWatch(std::size_t places, double limit, bool falling)
    : limit_(limit), sign_(falling ? -1 : 1), loss_(places), before_(places) {}

void LevelWatch::update(double now, std::span<const double> values) {
  VOLUTE_ASSERT(values.size() == before_.size());
  for (std::size_t i = 0; i < values.size(); ++i) note(i, now, values[i], {now, now});
}

void LevelWatch::begin(std::size_t place, double since) {
  Before& before = before_[place];
  before = {.since = since, .lost = before.lost};
}

void LevelWatch::lose(std::size_t place) {
  Before& before = before_[place];
  if (before.lost)
    return;
  before.gap = true;
  loss_.lose(place, before.known ? before.time : -kNever);
}

void LevelWatch::note(std::size_t place, double now, double value, const StoredSpan& span) {
  Before& before = before_[place];
  if (before.lost)
    return;
  if (std::isnan(value))
    return lose(place);
  const double level = sign_ * value, limit = sign_ * limit_;
  if (level >= limit) {
    if (before.gap) {
      loss_.note(place, now, now, now);
    } else if (before.known) {
      const double old = sign_ * before.value;
      const double between = before.time + (limit - old) / (level - old) * (now - before.time);
      loss_.note(place, std::max(before.from, before.since), std::min(between, now),
                 std::max(now, span.until));
    } else {
      const double since = std::isinf(before.since) ? now : before.since;
      loss_.note(place, since, since, now);
    }
    before.lost = true;
    return;
  }
  // A value that is taken as that of the last stored time is known until then.
  before = {std::min(now, span.until),
            std::min(now, span.from),
            value,
            before.since,
            true,
            before.gap,
            false};
}

SignLoss::SignLoss(std::span<const SightTarget> signs, std::vector<std::vector<std::size_t>> sets,
                   std::size_t eyes, std::vector<double> factors)
    : eyes_(eyes),
      signs_(signs.size()),
      times_{kNever, -kNever},
      depth_(signs.size() * eyes),
      state_(depth_.size()) {
  for (auto& members : sets) losses_.push_back({.members = std::move(members)});
  for (const double factor : factors)
    losses_.push_back({.members = losses_.front().members, .factor = factor, .hasBest = false});
  for (Set& set : losses_) set.middle.resize(eyes);
}

void SignLoss::splitBounds() {
  low_.assign(depth_.begin(), depth_.end());
  high_ = low_;
  for (Set& set : losses_) {
    set.worst = set.middle;
    if (set.hasBest)
      set.best = set.middle;
  }
}

void SignLoss::update(double now, std::span<const Sighting> sightings) {
  VOLUTE_ASSERT(sightings.size() == depth_.size());
  if (times_.size() == 2 || times_.back() != now)
    times_.push_back(now);
  VOLUTE_ASSERT(times_.size() <= kMaxTimes + 2);
  if (low_.empty() && std::ranges::any_of(sightings, [](const Sighting& one) {
        return one.covered && (one.low != one.depth || one.high != one.depth);
      }))
    splitBounds();
  constexpr std::size_t kEyes = 256;
  parallelRanges(eyes_, kEyes, [&](std::size_t begin, std::size_t end) {
    for (std::size_t eye = begin; eye < end; ++eye) updateEye(eye, sightings);
  });
  last_ = times_.size() - 1;
  for (std::size_t set = 0; set < losses_.size() && !begun_; ++set)
    losses_[set].first = inSight(set);
  begun_ = true;
}

void SignLoss::loseAll() {
  for (Set& set : losses_) {
    for (auto* losses : {&set.middle, &set.worst, &set.best}) {
      for (Loss& loss : *losses) loss.known = Loss::kNeverKnown;
    }
  }
}

void SignLoss::loseRest() {
  for (Set& set : losses_) {
    for (auto* losses : {&set.middle, &set.worst, &set.best}) {
      for (Loss& loss : *losses) {
        if (loss.begun != 0 && loss.up == Loss::kNever && loss.known == Loss::kAlways)
          loss.known = last_;
      }
    }
  }
}

LossTimes SignLoss::timesOf(const std::vector<Loss>& losses) const {
  constexpr std::size_t kFirst = 2;  // in times_
  LossTimes times(losses.size());
  for (std::size_t i = 0; i < losses.size(); ++i) {
    if (losses[i].begun == 0 && begun_) {
      times.note(i, times_[kFirst], times_[kFirst], times_[kFirst]);
    } else {
      times.down[i] = times_[losses[i].down];
      times.none[i] = losses[i].none;
      times.up[i] = times_[losses[i].up];
    }
    if (losses[i].known != Loss::kAlways)
      times.lose(i, times_[losses[i].known]);
  }
  return times;
}

LossTimes SignLoss::latest(std::size_t set) const {
  VOLUTE_ASSERT(losses_[set].hasBest);
  return timesOf(losses_[set].best.empty() ? losses_[set].middle : losses_[set].best);
}

std::vector<bool> SignLoss::inSight(std::size_t set) const {
  std::vector<bool> in;
  for (const Loss& loss : losses_[set].middle) in.push_back(loss.begun != 0);
  return in;
}

std::vector<bool> SignLoss::inSightLater(std::size_t set) const {
  std::vector<bool> later = inSight(set);
  for (std::size_t i = 0; i < later.size(); ++i) later[i] = later[i] && !losses_[set].first[i];
  return later;
}

void SignLoss::updateEye(std::size_t eye, std::span<const Sighting> sightings) {
  const auto at = [&](std::size_t sign) { return sign * eyes_ + eye; };
  const std::uint64_t nowPlace = times_.size() - 1;
  const double now = times_.back();
  const auto isOpen = [&](std::size_t line) {
    return !sightings[line].blocked && sightings[line].limit > 0;
  };

  // What of a line is compared, at the time before and now.
  struct Depth {
    double before = 0, now = 0;
  };

  const auto middleOf = [&](std::size_t line) {
    const Sighting& fresh = sightings[line];
    return Depth{depth_[line], fresh.covered ? fresh.depth : fresh.low};
  };
  const auto lowOf = [&](std::size_t line) {
    return low_.empty() ? middleOf(line) : Depth{low_[line], sightings[line].low};
  };
  const auto highOf = [&](std::size_t line) {
    return high_.empty() ? middleOf(line) : Depth{high_[line], sightings[line].high};
  };
  thread_local std::vector<Span> spans;
  const auto follow = [&](const Set& set, Loss& loss, const auto& depthOf) {
    const bool begun = loss.begun != 0;
    if (!begun &&
        std::ranges::none_of(set.members, [&](std::size_t sign) { return isOpen(at(sign)); }))
      return;
    loss.begun = 1;
    // How far from the time before on some sign is seen without a gap.
    double reach = begun ? 0 : 1;
    bool seen = false, begins = false;
    bool perhaps = false;  // on lines that are not known everywhere
    spans.clear();
    for (const std::size_t sign : set.members) {
      const std::size_t line = at(sign);
      const double limit = set.factor * sightings[line].limit;
      const bool covered = sightings[line].covered;
      if (isOpen(line)) {
        seen |= covered && depthOf(line).now <= limit;
        perhaps |= !covered && lowOf(line).now <= limit;
      }
      if (!begun || (state_[line] & kOpen) == 0)
        continue;
      if (covered && (state_[line] & kCovered) != 0) {
        spans.push_back(atMost(limit, depthOf(line).before, depthOf(line).now));
      } else {
        const Depth low = lowOf(line);
        perhaps |= std::min(low.before, low.now) <= limit;
      }
    }
    std::ranges::sort(spans, {}, &Span::begin);
    for (const Span& span : spans) {
      if (span.begin <= reach && span.end >= span.begin) {
        begins = true;
        reach = std::max(reach, span.end);
      }
    }
    if (begun && !begins)
      reach = 0;
    if (reach >= 1 && seen)
      return;
    const std::uint64_t last = begun ? last_ : nowPlace;
    const bool complete = loss.known == Loss::kAlways;
    if (perhaps) {
      // Before a sign came into sight nothing was lost.
      const std::uint64_t until = begun || begun_ ? last : Loss::kNeverKnown;
      if (complete || times_[until] < times_[loss.known])
        loss.known = until;
    } else if (complete || !seen) {
      const double from = times_[last];
      loss.down = complete ? last : nowPlace;
      loss.none = complete ? from + reach * (now - from) : now;
      loss.up = nowPlace;
    }
  };
  for (Set& set : losses_) {
    const Loss& longest = !set.best.empty() ? set.best[eye] : set.middle[eye];
    if (longest.up != Loss::kNever)
      continue;  // lost at any depth
    if (set.middle[eye].up == Loss::kNever)
      follow(set, set.middle[eye], middleOf);
    if (!set.worst.empty() && set.worst[eye].up == Loss::kNever)
      follow(set, set.worst[eye], highOf);
    if (!set.best.empty())
      follow(set, set.best[eye], lowOf);
  }
  for (std::size_t sign = 0; sign < signs_; ++sign) {
    const std::size_t line = at(sign);
    const Sighting& fresh = sightings[line];
    depth_[line] = fresh.covered ? fresh.depth : fresh.low;
    if (!low_.empty()) {
      constexpr float kMax = std::numeric_limits<float>::infinity();
      const auto low = static_cast<float>(fresh.low), high = static_cast<float>(fresh.high);
      low_[line] = low > fresh.low ? std::nextafter(low, -kMax) : low;
      high_[line] = high < fresh.high ? std::nextafter(high, kMax) : high;
    }
    state_[line] = (isOpen(line) ? kOpen : 0) | (fresh.covered ? kCovered : 0);
  }
}

}  // namespace volute
