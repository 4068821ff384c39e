// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/exposure_meter.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "volute/base/parallel.hpp"

namespace volute {
namespace {

constexpr double kNotKnown = std::numeric_limits<double>::quiet_NaN();

/// Of the extinction where people are.
bool isOfSmoke(const Criterion& criterion) {
  return !criterion.law && criterion.quantity == Air::kExtinction;
}

/// What a case stores and nobody can read.
class UnreadPoints final : public PointField {
 public:
  UnreadPoints(std::string why, std::span<const double> times)
      : why_(std::move(why)), times_(times.begin(), times.end()) {}

  std::string description() const override { return why_; }

  std::span<const double> times() const override { return times_; }

  Status at(double, std::span<const Vec3>, std::span<double> out) override {
    std::ranges::fill(out, kNotKnown);
    return {};
  }

  std::vector<ServedSource> sources() const override { return {{why_, 0, {}, std::nullopt}}; }

 private:
  std::string why_;
  std::vector<double> times_;
};

std::string whyNot(const AirField& air, const Criterion& criterion) {
  std::vector<std::string> reasons;
  for (const Air one : criterion.needed()) {
    if (!air.has(one) && std::ranges::find(reasons, air.gap(one)) == reasons.end())
      reasons.push_back(air.gap(one));
  }
  return fmt::format("{}", fmt::join(reasons, "; "));
}

}  // namespace

AirField AirField::open(SightField& field, std::span<const Criterion> criteria, double smokeFrom) {
  AirField air;
  std::array<bool, kAirQuantities> wanted{};
  for (const Criterion& criterion : criteria) {
    for (const Air one : criterion.needed()) wanted[index(one)] = true;
    for (const Air one : criterion.taken()) wanted[index(one)] = true;
  }
  for (const AirQuantity& one : airQuantities()) {
    if (!wanted[index(one.quantity)] || one.quantity == Air::kExtinction)
      continue;
    auto opened = field.conditions(one.name);
    if (opened) {
      air.fields_[index(one.quantity)] = std::move(*opened);
    } else if (opened.error().code == ErrorCode::kNotFound) {
      air.gaps_[index(one.quantity)] = opened.error().message;
    } else {
      air.fields_[index(one.quantity)] =
          std::make_unique<UnreadPoints>(opened.error().message, field.times());
    }
  }
  air.begin_ = std::min(field.begin(), field.times().front());
  for (const auto& one : air.fields_) {
    if (one)
      air.begin_ = std::min(air.begin_, one->times().front());
  }
  for (const auto& one : air.fields_) {
    if (one && one->sources().front().times > 0)
      air.end_ = std::max(air.end_, one->times().back());
  }
  air.smokeIsLate_ = smokeFrom > field.times().front() || !storedPlace(field.times(), air.begin_);
  return air;
}

std::string AirField::description(Air air) const {
  return fields_[index(air)] ? fields_[index(air)]->description() : "";
}

std::vector<ServedSource> AirField::sources(Air air) const {
  return fields_[index(air)] ? fields_[index(air)]->sources() : std::vector<ServedSource>();
}

std::string AirField::unread(Air air) const {
  std::string all;
  for (const ServedSource& one : sources(air)) {
    if (one.times == 0)
      all += (all.empty() ? "" : "; ") + one.description;
  }
  return all;
}

std::vector<double> AirField::timesBetween(double from, double to) const {
  std::vector<double> times;
  for (const auto& field : fields_) {
    if (!field)
      continue;
    for (const double time : field->times()) {
      if (time > from && time < to)
        times.push_back(time);
    }
  }
  std::ranges::sort(times);
  times.erase(std::ranges::unique(times).begin(), times.end());
  return times;
}

Exposure AirField::unknown() {
  Exposure air;
  for (const AirQuantity& one : airQuantities()) air[one.quantity] = kNotKnown;
  return air;
}

bool AirField::isExact(const Criterion& criterion) const {
  for (const auto& quantities : {criterion.needed(), criterion.taken()}) {
    for (const Air one : quantities) {
      if (fields_[index(one)] && !fields_[index(one)]->isExact())
        return false;
    }
  }
  return true;
}

Status AirField::at(double time, std::span<const Vec3> points, std::span<Exposure> out,
                    std::span<Around> around) {
  std::vector<PointValue> values(points.size());
  for (const AirQuantity& one : airQuantities()) {
    PointField* field = fields_[index(one.quantity)].get();
    if (field == nullptr)
      continue;
    std::ranges::fill(values, PointValue{.span = {time, time}});
    VOLUTE_TRY(field->answer(time, points, values));
    const bool lessIsWorse = one.quantity == Air::kOxygen;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const PointValue& value = values[i];
      out[i][one.quantity] = value.value;
      if (around.empty())
        continue;
      around[i].worst[one.quantity] = lessIsWorse ? value.low : value.high;
      around[i].least[one.quantity] = lessIsWorse ? value.high : value.low;
      around[i].spans[index(one.quantity)] = value.span;
    }
  }
  return {};
}

ExposureMeter::Course::Course(std::size_t people)
    : values(people, 0.0), rates(people, kNotKnown), worst(people, kNotKnown) {}

ExposureMeter::ExposureMeter(AirField air, std::span<const Criterion> criteria, std::size_t people,
                             bool rooms)
    : air_(std::move(air)), people_(people) {
  for (const Criterion& criterion : criteria) {
    if (!rooms && !criterion.isForRoom(kNotKnown)) {
      missing_.push_back(
          {criterion,
           fmt::format("it is for rooms below {:g} m2, and rooms are known of plans alone",
                       criterion.roomBelow)});
      continue;
    }
    if (!criterion.assessable([&](Air one) { return air_.has(one); })) {
      missing_.push_back({criterion, whyNot(air_, criterion)});
      continue;
    }
    criteria_.push_back(criterion);
    watches_.emplace_back(people, criterion.limit, criterion.falling);
    const bool exact = air_.isExact(criterion);
    least_.emplace_back(!exact || isOfSmoke(criterion) ? people : 0, criterion.limit,
                        criterion.falling);
    means_.emplace_back(people);
    most_.emplace_back(exact ? 0 : people);
    fewest_.emplace_back(exact ? 0 : people);
  }
  unknown_.assign(criteria_.size(), std::vector<char>(people, 0));
  there_.assign(people, 0);
  since_.assign(people, 0);
}

std::uint64_t ExposureMeter::bytesOfPerson(const AirField& air, std::span<const Criterion> criteria,
                                           bool rooms) {
  constexpr std::uint64_t kCourse = 3 * sizeof(double);
  std::uint64_t bytes = 0;
  for (const Criterion& criterion : criteria) {
    if (!(rooms || criterion.isForRoom(kNotKnown)) ||
        !criterion.assessable([&](Air one) { return air.has(one); }))
      continue;
    const bool exact = air.isExact(criterion);
    const std::uint64_t watches = exact && !isOfSmoke(criterion) ? 1 : 2;
    bytes += watches * LevelWatch::kBytesOfPlace + (exact ? 1 : 3) * kCourse + 1;
  }
  const std::uint64_t ofATime =
      sizeof(Exposure) + sizeof(AirField::Around) + 2 * sizeof(Vec3) + sizeof(std::size_t) + 1;
  return bytes == 0 ? 0 : bytes + ofATime;
}

void ExposureMeter::lose(std::size_t person) {
  for (std::size_t c = 0; c < criteria_.size(); ++c) {
    unknown_[c][person] = 1;
    watches_[c].lose(person);
    if (hasLeast(c))
      least_[c].lose(person);
  }
}

std::vector<Air> ExposureMeter::assumed(std::size_t criterion) const {
  std::vector<Air> absent;
  auto all = criteria_[criterion].taken();
  const auto needed = criteria_[criterion].needed();
  all.insert(all.end(), needed.begin(), needed.end());
  for (const Air one : all) {
    if (!air_.has(one) && std::ranges::find(absent, one) == absent.end())
      absent.push_back(one);
  }
  return absent;
}

std::string ExposureMeter::unread(std::size_t criterion) const {
  std::string all;
  for (const auto& quantities : {criteria_[criterion].needed(), criteria_[criterion].taken()}) {
    for (const Air one : quantities) {
      const std::string why = air_.unread(one);
      all += (all.empty() || why.empty() ? "" : "; ") + why;
    }
  }
  return all;
}

bool ExposureMeter::isAssessed(std::size_t criterion) const {
  return !unread(criterion).empty() ||
         std::ranges::any_of(means_[criterion].worst,
                             [](double value) { return !std::isnan(value); });
}

Status ExposureMeter::advance(double time, const Places& places, const Smoke& smoke, double step,
                              const SmokeBetween& between, std::span<const Turn> turns) {
  if (criteria_.empty())
    return {};
  if (!begun_) {
    last_ = std::min(time, air_.begin());
    if (last_ < time)
      VOLUTE_TRY(sample(last_, places, {}));
    if (air_.smokeIsLate())
      loseSmoke();
  }
  auto times = air_.timesBetween(last_, time);
  if (std::isfinite(step)) {
    const double from = last_;
    for (int i = 1; from + i * step < time; ++i) times.push_back(from + i * step);
    std::ranges::sort(times);
  }
  smokeSpan_ = {begunSmoke_ ? smokeSpan_.until : time, time};
  tookLeast_ = tookLeast_ || !smoke.least.empty();
  std::vector<double> most(between ? people_ : 0), least(smoke.least.empty() ? 0 : most.size());
  const auto take = [&](double early, std::span<const Turn> alone) {
    if (between && begun_ && begunSmoke_)
      between(early, most, least);
    return sample(early, places, begunSmoke_ ? Smoke{most, least} : Smoke{}, alone);
  };
  auto turn = std::ranges::upper_bound(turns, last_, {}, &Turn::time);
  const auto takeTurns = [&](double until) -> Status {
    while (turn != turns.end() && turn->time < until) {
      const auto end = std::ranges::upper_bound(turn, turns.end(), turn->time, {}, &Turn::time);
      VOLUTE_TRY(take(turn->time, {turn, end}));
      turn = end;
    }
    while (turn != turns.end() && turn->time <= until) ++turn;  // is taken with all others
    return {};
  };
  for (const double early : times) {
    VOLUTE_TRY(takeTurns(early));
    VOLUTE_TRY(take(early, {}));
  }
  VOLUTE_TRY(takeTurns(time));
  begunSmoke_ = true;
  return sample(time, places, smoke);
}

void ExposureMeter::loseSmoke() {
  for (std::size_t c = 0; c < criteria_.size(); ++c) {
    if (!isOfSmoke(criteria_[c]))
      continue;
    std::ranges::fill(unknown_[c], 1);
    for (std::size_t i = 0; i < people_; ++i) {
      watches_[c].lose(i);
      least_[c].lose(i);
    }
  }
}

const LossTimes* ExposureMeter::latest(std::size_t criterion) const {
  const bool open = isOfSmoke(criteria_[criterion]) ? tookLeast_ : !most_[criterion].empty();
  return open ? &least_[criterion].times() : nullptr;
}

/// Whether the least that the data allow is followed, too.
bool ExposureMeter::hasLeast(std::size_t criterion) const {
  return !most_[criterion].empty() || isOfSmoke(criteria_[criterion]);
}

/// @param alone  who is asked; empty: everybody
Status ExposureMeter::sample(double time, const Places& places, const Smoke& smoke,
                             std::span<const Turn> alone) {
  std::vector<Vec3> points(people_), present;
  places(time, points);
  std::vector<std::size_t> people(alone.empty() ? people_ : 0);
  std::iota(people.begin(), people.end(), std::size_t{0});
  for (const Turn& one : alone) people.push_back(one.person);
  for (const std::size_t i : people) {
    if (!std::isnan(points[i][0]))
      present.push_back(points[i]);
  }
  // Kept from time to time: what is not stored stays as it was made.
  constexpr double kNever = std::numeric_limits<double>::infinity();
  AirField::Around none;
  none.spans.fill({kNever, -kNever});
  if (inAir_.size() < present.size()) {
    inAir_.resize(present.size(), AirField::unknown());
    around_.resize(present.size(), none);
  }
  const std::span air(inAir_.data(), present.size());
  const std::span around(around_.data(), present.size());
  VOLUTE_TRY(air_.at(time, present, air, around));
  std::vector<std::size_t> place(people_);  // in `air`
  std::size_t placed = 0;
  for (const std::size_t i : people) place[i] = std::isnan(points[i][0]) ? 0 : placed++;
  for (std::size_t c = 0; c < criteria_.size(); ++c) {
    const Criterion& criterion = criteria_[c];
    const bool ofSmoke = isOfSmoke(criterion);
    const std::vector<Air> needed = criterion.needed(), taken = criterion.taken();
    Course &means = means_[c], &most = most_[c], &fewest = fewest_[c];
    const bool open = !most.empty(), bounded = hasLeast(c);
    parallelRanges(people.size(), 512, [&](std::size_t begin, std::size_t end) {
      for (std::size_t p = begin; p < end; ++p) {
        const std::size_t i = people[p];
        const double passed = begun_ ? time - since_[i] : 0;
        if (std::isnan(points[i][0])) {
          means.rates[i] = kNotKnown;
          if (open)
            most.rates[i] = fewest.rates[i] = kNotKnown;
          if (!criterion.isDose())
            means.values[i] = kNotKnown;
          // Somebody who came and went between two times at which the smoke is known.
          if (there_[i] != 0 && !watches_[c].hasBegun(i)) {
            unknown_[c][i] = 1;
            watches_[c].lose(i);
            if (bounded)
              least_[c].lose(i);
          }
          continue;
        }
        if (there_[i] == 0 && begun_) {
          watches_[c].begin(i, time);
          if (bounded)
            least_[c].begin(i, time);
        }
        if (ofSmoke && smoke.most.empty())
          continue;
        const double value = ofSmoke ? smoke.most[i] : criterion.value(air[place[i]]);
        const bool known = !std::isnan(value);
        // What is stored, but not here and now, does not count as in clean air.
        const auto isHere = [&](Air one) {
          return !air_.has(one) || !std::isnan(air[place[i]][one]);
        };
        const bool whole = known && (ofSmoke || (std::ranges::all_of(needed, isHere) &&
                                                 std::ranges::all_of(taken, isHere)));
        StoredSpan span{time, time};
        if (ofSmoke && time < smokeSpan_.until)
          span = smokeSpan_;
        const auto widen = [&](Air one) {
          const StoredSpan& own = around[place[i]].spans[static_cast<std::size_t>(one)];
          span = {std::min(span.from, own.from), std::max(span.until, own.until)};
        };
        if (!ofSmoke) {
          std::ranges::for_each(needed, widen);
          std::ranges::for_each(taken, widen);
        }
        if (!whole) {
          unknown_[c][i] = 1;
          watches_[c].lose(i);
          if (bounded)
            least_[c].lose(i);
        }
        // Doses grow by rates at both ends, and do not while one is not known.
        const auto follow = [&](Course& course, double now) {
          double& so = course.values[i];
          double& before = course.rates[i];
          double& worst = course.worst[i];
          if (!criterion.isDose())
            so = now;
          else if (known && !std::isnan(before) && there_[i] != 0)
            so += 0.5 * (before + now) * passed;
          before = now;
          const double compared = known ? so : kNotKnown;
          if (std::isnan(worst))
            worst = compared;
          else if (!std::isnan(compared))
            worst = criterion.falling ? std::min(worst, compared) : std::max(worst, compared);
          return compared;
        };
        const double mean = follow(means, value);
        if (!open) {
          if (known)
            watches_[c].note(i, time, mean, span);
          if (known && ofSmoke && !smoke.least.empty())
            least_[c].note(i, time, smoke.least[i], span);
          continue;
        }
        double worse = criterion.value(around[place[i]].worst);
        double better = criterion.value(around[place[i]].least);
        if (criterion.falling ? worse > better : worse < better)
          std::swap(worse, better);
        worse = follow(most, worse);
        better = follow(fewest, better);
        if (known) {
          watches_[c].note(i, time, worse, span);
          least_[c].note(i, time, better, span);
        }
      }
    });
  }
  for (const std::size_t i : people) {
    there_[i] = std::isnan(points[i][0]) ? 0 : 1;
    since_[i] = time;
  }
  last_ = time;
  begun_ = true;
  return {};
}

}  // namespace volute
