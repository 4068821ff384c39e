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

LossTimes::LossTimes(std::size_t places) : down(places, kNever), none(down), up(down) {}

const std::vector<double>& LossTimes::by(RoundTime round) const {
  return round == RoundTime::kDown ? down : (round == RoundTime::kUp ? up : none);
}

LevelWatch::LevelWatch(std::size_t places, double limit, bool falling)
    : limit_(limit), sign_(falling ? -1 : 1), loss_(places) {}

void LevelWatch::update(double now, std::span<const double> values) {
  VOLUTE_ASSERT(values.size() == loss_.up.size());
  const bool begun = !values_.empty();
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double limit = sign_ * limit_, value = sign_ * values[i];
    if (!(value >= limit))
      continue;
    const double old = begun ? sign_ * values_[i] : kNever;
    const double last = begun ? before_ : now;
    const double between =
        old < limit ? last + (limit - old) / (value - old) * (now - last) : (begun ? last : now);
    loss_.note(i, last, std::min(between, now), now);
  }
  values_.assign(values.begin(), values.end());
  before_ = now;
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
    fresh[s] = {sighting.depth, sighting.low, sighting.high, !sighting.blocked && limits_[at] > 0};
  }
  const double last = begun_ ? before_ : now;
  const auto follow = [&](std::size_t set, LossTimes& loss, double Line::* depth) {
    // How far from the time before on some sign is seen without a gap.
    double reach = begun_ ? 0 : 1;
    bool seen = false, begins = false;
    std::vector<Span> spans;
    for (const std::size_t s : sets_[set]) {
      const std::size_t at = s * eyes_ + eye;
      const double limit = factors_[set] * limits_[at];
      seen |= fresh[s].open && fresh[s].*depth <= limit;
      if (begun_ && lines_[at].open)
        spans.push_back(atMost(limit, lines_[at].*depth, fresh[s].*depth));
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
    if (reach < 1 || !seen)
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
