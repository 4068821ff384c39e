// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/sight_engine.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <unordered_set>

#include "volute/base/assert.hpp"
#include "volute/base/parallel.hpp"

namespace volute {
namespace {

constexpr std::size_t kAgents = 64;  // whose lines to a sign are looked along together

/// Fields of so many values are interpolated for each time that is asked for; of larger ones lines
/// are looked along at both stored times around it.
constexpr std::size_t kSmall = 200'000;

}  // namespace

Result<SightEngine> SightEngine::open(std::shared_ptr<SightField> field,
                                      std::span<const SafetySign> signs,
                                      std::span<const Criterion> criteria, Progress& progress) {
  SightEngine engine;
  engine.field_ = std::move(field);
  for (const Remark& remark : engine.field_->remarks()) progress.remark(remark);
  VOLUTE_ASSIGN(const auto first, engine.stored(0));
  VOLUTE_ASSIGN(engine.signs_, placeSigns(*first, signs, engine.field_->bounds(), progress));
  const ExposureMeter meter(AirField::open(*engine.field_, criteria), criteria, 0);
  engine.criteria_ = meter.criteria();
  engine.missing_ = meter.missing();
  engine.air_ = AirField::open(*engine.field_, engine.criteria_);
  engine.small_ = first->data().value.size() <= kSmall;
  engine.changes_ = engine.field_->changes();
  return engine;
}

Result<std::shared_ptr<const SightSnapshot>> SightEngine::stored(std::size_t index) {
  if (const auto found = held_.find(index); found != held_.end())
    return found->second;
  VOLUTE_ASSIGN(auto snapshot, field_->read(index));
  if (held_.size() == 2)
    held_.erase(held_.begin()->first < index ? held_.begin() : std::prev(held_.end()));
  return held_[index] = std::move(snapshot);
}

/// Whether something opaque has come or gone since a stored time.
bool SightEngine::changed(double stored, double now) const {
  return std::ranges::any_of(changes_,
                             [&](double change) { return change > stored && change <= now; });
}

bool SightEngine::knows(double t) const {
  return storedPlace(field_->times(), t).has_value();
}

Result<SightEngine::Snapshots> SightEngine::snapshotsAt(double t) {
  if (t == time_)
    return snapshots_;
  const auto times = field_->times();
  const double within = std::clamp(t, times.front(), times.back());
  const auto after = std::ranges::upper_bound(times, within);
  const auto first = static_cast<std::size_t>(after - times.begin()) - 1;
  Snapshots now;
  if (times[first] == within || first + 1 == times.size()) {
    VOLUTE_ASSIGN(now.before, stored(first));
  } else if (field_->interpolates() && (small_ || changed(times[first], within))) {
    VOLUTE_ASSIGN(now.before, field_->readAt(within));
  } else {
    VOLUTE_ASSIGN(now.before, stored(first));
    VOLUTE_ASSIGN(now.after, stored(first + 1));
    now.share = (within - times[first]) / (times[first + 1] - times[first]);
  }
  time_ = t;
  snapshots_ = now;
  return now;
}

Status SightEngine::sees(std::span<const Vec3> eyes, double t, std::span<Seen> out) {
  VOLUTE_ASSERT(out.size() == signs_.size() * eyes.size());
  if (!knows(t)) {
    std::ranges::fill(out, Seen::kCannotTell);
    return {};
  }
  VOLUTE_ASSIGN(const Snapshots now, snapshotsAt(t));
  // What snapshots make once is made here: in the loop a thread might wait for itself.
  for (const auto& snapshot : {now.before, now.after}) {
    if (snapshot)
      snapshot->bounds({}, {}, {});
  }
  const std::size_t batches = (eyes.size() + kAgents - 1) / kAgents;
  parallelRanges(signs_.size() * batches, 1, [&](std::size_t begin, std::size_t end) {
    Lines lines, open, exact;
    for (std::size_t b = begin; b < end; ++b) {
      const std::size_t s = b / batches, first = b % batches * kAgents;
      const SightTarget& target = signs_[s];
      lines.clear(), open.clear(), exact.clear();
      for (std::size_t i = first; i < std::min(first + kAgents, eyes.size()); ++i) {
        const std::size_t at = s * eyes.size() + i;
        out[at] = Seen::kNo;
        const Vec3 way = eyes[i] - target.sign.position;
        const double distance = way.norm();
        const double cosine =
            distance > 0 ? std::clamp(target.sign.normal.dot(way) / distance, -1.0, 1.0) : 1;
        const double limit = target.sign.law.c * target.sign.angle.factor(cosine);
        if (limit > 0)  // else averted: nothing to look along
          lines.add({eyes[i], target.target}, at, limit);
      }
      // Most lines are decided by blocks of cells, and by what stands in the way.
      const auto [low, high] = boundsOf(now, lines.lines);
      for (std::size_t k = 0; k < lines.size(); ++k) {
        if (low[k] <= lines.limits[k])
          open.add(lines, k, high[k]);
      }
      std::vector<unsigned char> blocked(open.size());
      now.before->blocked(open.lines, blocked);
      for (std::size_t k = 0; k < open.size(); ++k) {
        if (blocked[k] != 0)
          continue;
        if (open.highs[k] <= open.limits[k])
          out[open.places[k]] = Seen::kYes;
        else
          exact.add(open, k, open.highs[k]);
      }
      lookExactly(now, exact, out);
    }
  });
  return {};
}

std::pair<std::vector<double>, std::vector<double>> SightEngine::boundsOf(
    const Snapshots& now, std::span<const SightLine> lines) {
  std::vector<double> low(lines.size()), high(lines.size());
  now.before->bounds(lines, low, high);
  if (now.after) {
    std::vector<double> lowLater(lines.size()), highLater(lines.size());
    now.after->bounds(lines, lowLater, highLater);
    for (std::size_t k = 0; k < lines.size(); ++k) {
      low[k] += now.share * (lowLater[k] - low[k]);
      high[k] = std::isinf(high[k]) || std::isinf(highLater[k])
                    ? std::numeric_limits<double>::infinity()
                    : high[k] + now.share * (highLater[k] - high[k]);
    }
  }
  return {std::move(low), std::move(high)};
}

/// Along each line; none is blocked.
void SightEngine::lookExactly(const Snapshots& now, const Lines& lines, std::span<Seen> out) {
  if (lines.size() == 0)
    return;
  std::vector<Sight> sights(lines.size()), later(now.after ? lines.size() : 0);
  now.before->look(lines.lines, sights);
  if (now.after)
    now.after->look(lines.lines, later);
  for (std::size_t k = 0; k < lines.size(); ++k) {
    const Sight& sight = sights[k];
    const auto depth = [&](double Sight::* which) {
      return now.after ? sight.*which + now.share * (later[k].*which - sight.*which) : sight.*which;
    };
    const bool covered = sight.covered && (!now.after || later[k].covered);
    const bool possibly = depth(&Sight::low) <= lines.limits[k];
    const bool certainly = covered && depth(&Sight::high) <= lines.limits[k];
    out[lines.places[k]] = certainly ? Seen::kYes : (possibly ? Seen::kCannotTell : Seen::kNo);
  }
}

Status SightEngine::extinction(std::span<const Vec3> eyes, double t, std::span<double> out) {
  VOLUTE_ASSERT(out.size() == eyes.size());
  if (!knows(t)) {
    std::ranges::fill(out, std::numeric_limits<double>::quiet_NaN());
    return {};
  }
  VOLUTE_ASSIGN(const Snapshots now, snapshotsAt(t));
  parallelRanges(eyes.size(), 256, [&](std::size_t begin, std::size_t end) {
    const auto part = out.subspan(begin, end - begin);
    now.before->extinction(eyes.subspan(begin, end - begin), part);
    if (!now.after)
      return;
    std::vector<double> later(end - begin);
    now.after->extinction(eyes.subspan(begin, end - begin), later);
    for (std::size_t i = 0; i < later.size(); ++i) part[i] += now.share * (later[i] - part[i]);
  });
  return {};
}

Status SightEngine::largestExtinction(std::span<const Vec3> eyes, double t, std::span<double> out) {
  std::ranges::fill(out, std::numeric_limits<double>::quiet_NaN());
  if (!knows(t))
    return {};
  VOLUTE_ASSIGN(const Snapshots now, snapshotsAt(t));
  std::vector<double> low(eyes.size()), later(eyes.size());
  now.before->extinctionBounds(eyes, low, out);
  if (!now.after)
    return {};
  now.after->extinctionBounds(eyes, low, later);
  for (std::size_t i = 0; i < eyes.size(); ++i) out[i] = mixed(out[i], later[i], now.share);
  return {};
}

Status SightEngine::dose(std::span<const std::int64_t> ids, std::span<const Vec3> eyes, double t,
                         std::span<double> out, std::span<double> worst) {
  VOLUTE_ASSERT(ids.size() == eyes.size() && out.size() == criteria_.size() * ids.size());
  VOLUTE_ASSERT(worst.empty() || worst.size() == out.size());
  std::unordered_set<std::int64_t> known;
  for (const std::int64_t id : ids) {
    if (!known.insert(id).second)
      return fail(ErrorCode::kInvalidArgument,
                  "agent {} is among the ids twice; expected each agent once", id);
  }
  std::vector<Exposure> air(eyes.size(), AirField::unknown());
  std::vector<AirField::Around> around(eyes.size());
  VOLUTE_TRY(air_.at(t, eyes, air, around));
  const bool ofSmoke = std::ranges::any_of(
      criteria_, [](const Criterion& one) { return !one.law && one.quantity == Air::kExtinction; });
  if (ofSmoke) {
    std::vector<double> k(eyes.size()), most(eyes.size());
    VOLUTE_TRY(extinction(eyes, t, k));
    if (!worst.empty())
      VOLUTE_TRY(largestExtinction(eyes, t, most));
    for (std::size_t i = 0; i < eyes.size(); ++i) {
      air[i][Air::kExtinction] = around[i].least[Air::kExtinction] = k[i];
      around[i].worst[Air::kExtinction] = most[i];
    }
  }
  constexpr double kNotKnown = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = 0; i < ids.size(); ++i) {
    Agent& agent = agents_[ids[i]];
    const bool fresh = agent.mean.rates.empty();
    if (fresh) {
      for (Course* course : {&agent.mean, &agent.worst}) {
        course->rates.assign(criteria_.size(), kNotKnown);
        course->doses.assign(criteria_.size(), 0.0);
      }
    }
    const double passed = !fresh && called_ && agent.time == lastCall_ ? t - agent.time : 0;
    for (std::size_t c = 0; c < criteria_.size(); ++c) {
      const Criterion& criterion = criteria_[c];
      const auto isHere = [&](Air one) { return !air_.has(one) || !std::isnan(air[i][one]); };
      const auto follow = [&](Course& course, double value) {
        if (!criterion.isDose())
          return value;
        double& dose = course.doses[c];
        if (std::isnan(value) || !std::ranges::all_of(criterion.taken(), isHere))
          dose = kNotKnown;  // from now on
        if (passed > 0)
          dose += 0.5 * (course.rates[c] + value) * passed;
        course.rates[c] = value;
        return dose;
      };
      const std::size_t at = c * ids.size() + i;
      out[at] = follow(agent.mean, criterion.value(air[i]));
      const double one = criterion.value(around[i].worst), other = criterion.value(around[i].least);
      const double most =
          follow(agent.worst, criterion.falling ? std::fmin(one, other) : std::fmax(one, other));
      if (!worst.empty())
        worst[at] = most;
    }
    agent.time = t;
  }
  lastCall_ = t;
  called_ = true;
  return {};
}

}  // namespace volute
