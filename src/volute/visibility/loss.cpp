// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/loss.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "volute/base/assert.hpp"
#include "volute/base/parallel.hpp"

namespace volute {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

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

std::vector<double> LossTimes::answers(RoundTime round) const {
  std::vector<double> times = by(round);
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (!complete(i))
      times[i] = std::numeric_limits<double>::quiet_NaN();
  }
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
    : sets_(std::move(sets)),
      factors_(std::move(factors)),
      eyes_(eyes),
      limits_(signs.size() * eyes),
      lines_(limits_.size()) {
  factors_.resize(sets_.size(), 1);
  for (const SightTarget& sign : signs) signs_.push_back(&sign);
  loss_.assign(sets_.size(), {LossTimes(eyes), LossTimes(eyes), LossTimes(eyes)});
}

void SignLoss::update(double now, std::span<const Sighting> sightings) {
  VOLUTE_ASSERT(sightings.size() == lines_.size());
  constexpr std::size_t kEyes = 256;
  parallelRanges(eyes_, kEyes, [&](std::size_t begin, std::size_t end) {
    for (std::size_t eye = begin; eye < end; ++eye) updateEye(eye, now, sightings);
  });
  before_ = now;
  begun_ = true;
}

void SignLoss::loseAll() {
  for (Bounds& one : loss_) {
    for (LossTimes* times : {&one.middle, &one.worst, &one.best})
      std::ranges::fill(times->known, -kNever);
  }
}

void SignLoss::updateEye(std::size_t eye, double now, std::span<const Sighting> sightings) {
  std::vector<Line> fresh(signs_.size());
  for (std::size_t s = 0; s < signs_.size(); ++s) {
    const std::size_t at = s * eyes_ + eye;
    const Sighting& sighting = sightings[at];
    if (!begun_) {
      const SafetySign& sign = signs_[s]->sign;
      const double cosine = std::cos(sighting.angle * (std::numbers::pi / 180));
      limits_[at] = sign.law.c * sign.angle.factor(cosine);
    }
    fresh[s] = {sighting.depth, sighting.low, sighting.high, !sighting.blocked && limits_[at] > 0,
                sighting.covered};
  }
  const double last = begun_ ? before_ : now;
  const auto follow = [&](std::size_t set, LossTimes& loss, double Line::* depth) {
    // How far from the time before on some sign is seen without a gap.
    double reach = begun_ ? 0 : 1;
    bool seen = false, begins = false;
    bool perhaps = false;  // on lines that are not known everywhere
    std::vector<Span> spans;
    for (const std::size_t s : sets_[set]) {
      const std::size_t at = s * eyes_ + eye;
      const double limit = factors_[set] * limits_[at];
      seen |= fresh[s].open && fresh[s].covered && fresh[s].*depth <= limit;
      perhaps |= fresh[s].open && !fresh[s].covered && fresh[s].low <= limit;
      if (!begun_ || !lines_[at].open)
        continue;
      if (lines_[at].covered && fresh[s].covered)
        spans.push_back(atMost(limit, lines_[at].*depth, fresh[s].*depth));
      else
        perhaps |= std::min(lines_[at].low, fresh[s].low) <= limit;
    }
    std::ranges::sort(spans, {}, &Span::begin);
    for (const Span& span : spans) {
      if (span.begin <= reach && span.end >= span.begin) {
        begins = true;
        reach = std::max(reach, span.end);
      }
    }
    if (begun_ && !begins)
      reach = 0;
    if (reach >= 1 && seen)
      return;
    if (perhaps)
      loss.lose(eye, begun_ ? last : -kNever);
    else if (!loss.complete(eye) && !seen)
      loss.note(eye, now, now, now);
    else if (loss.complete(eye))
      loss.note(eye, last, last + reach * (now - last), now);
  };
  for (std::size_t set = 0; set < sets_.size(); ++set) {
    if (loss_[set].best.up[eye] < kNever)
      continue;  // lost at any depth
    if (loss_[set].middle.up[eye] == kNever)
      follow(set, loss_[set].middle, &Line::depth);
    if (loss_[set].worst.up[eye] == kNever)
      follow(set, loss_[set].worst, &Line::high);
    follow(set, loss_[set].best, &Line::low);
  }
  for (std::size_t s = 0; s < signs_.size(); ++s) lines_[s * eyes_ + eye] = fresh[s];
}

}  // namespace volute
