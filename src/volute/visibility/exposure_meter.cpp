// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/exposure_meter.hpp"

#include <algorithm>
#include <cmath>

#include "volute/base/parallel.hpp"

namespace volute {
namespace {

constexpr double kNotKnown = std::numeric_limits<double>::quiet_NaN();

std::string whyNot(const AirField& air, const Criterion& criterion) {
  std::vector<std::string> reasons;
  for (const Air one : criterion.needed()) {
    if (!air.has(one) && std::ranges::find(reasons, air.gap(one)) == reasons.end())
      reasons.push_back(air.gap(one));
  }
  return fmt::format("{}", fmt::join(reasons, "; "));
}

}  // namespace

AirField AirField::open(SightField& field, std::span<const Criterion> criteria) {
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
    } else {
      air.gaps_[index(one.quantity)] = opened.error().message;
    }
  }
  return air;
}

std::string AirField::description(Air air) const {
  return fields_[index(air)] ? fields_[index(air)]->description() : "";
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

double AirField::begin() const {
  double begin = std::numeric_limits<double>::infinity();
  for (const auto& field : fields_) {
    if (field)
      begin = std::min(begin, field->times().front());
  }
  return begin;
}

Status AirField::at(double time, std::span<const Vec3> points, std::span<Exposure> out) {
  std::vector<double> values(points.size());
  for (const AirQuantity& one : airQuantities()) {
    PointField* field = fields_[index(one.quantity)].get();
    if (field != nullptr) {
      VOLUTE_TRY(field->at(time, points, values));
    } else {
      std::ranges::fill(values, kNotKnown);
    }
    for (std::size_t i = 0; i < points.size(); ++i) out[i][one.quantity] = values[i];
  }
  return {};
}

ExposureMeter::ExposureMeter(AirField air, std::span<const Criterion> criteria, std::size_t people)
    : air_(std::move(air)), people_(people) {
  for (const Criterion& criterion : criteria) {
    if (!criterion.assessable([&](Air one) { return air_.has(one); })) {
      missing_.push_back({criterion, whyNot(air_, criterion)});
      continue;
    }
    criteria_.push_back(criterion);
    watches_.emplace_back(people, criterion.limit, criterion.falling);
  }
  values_.assign(criteria_.size(), std::vector<double>(people, 0.0));
  worst_.assign(criteria_.size(), std::vector<double>(people, kNotKnown));
  rates_.assign(criteria_.size(), std::vector<double>(people, kNotKnown));
  unknown_.assign(criteria_.size(), std::vector<char>(people, 0));
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

Status ExposureMeter::advance(double time, const Places& places, std::span<const double> extinction,
                              double step) {
  if (criteria_.empty())
    return {};
  if (!begun_) {
    last_ = std::min(time, air_.begin());
    if (last_ < time)
      VOLUTE_TRY(sample(last_, places, {}));
  }
  auto times = air_.timesBetween(last_, time);
  if (std::isfinite(step)) {
    const double from = last_;
    for (int i = 1; from + i * step < time; ++i) times.push_back(from + i * step);
    std::ranges::sort(times);
  }
  for (const double between : times) VOLUTE_TRY(sample(between, places, {}));
  return sample(time, places, extinction);
}

Status ExposureMeter::sample(double time, const Places& places,
                             std::span<const double> extinction) {
  std::vector<Vec3> points(people_), present;
  places(time, points);
  for (const Vec3& point : points) {
    if (!std::isnan(point[0]))
      present.push_back(point);
  }
  std::vector<Exposure> air(present.size());
  VOLUTE_TRY(air_.at(time, present, air));
  std::vector<std::size_t> place(people_);  // in `air`
  for (std::size_t i = 0, n = 0; i < people_; ++i) place[i] = std::isnan(points[i][0]) ? 0 : n++;
  const double passed = begun_ ? time - last_ : 0;
  std::vector<double> compared(people_);
  for (std::size_t c = 0; c < criteria_.size(); ++c) {
    const Criterion& criterion = criteria_[c];
    const bool ofSmoke = !criterion.law && criterion.quantity == Air::kExtinction;
    if (ofSmoke && extinction.empty())
      continue;
    parallelRanges(people_, 512, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const bool there = !std::isnan(points[i][0]);
        const double value = !there    ? kNotKnown
                             : ofSmoke ? extinction[i]
                                       : criterion.value(air[place[i]]);
        const bool known = !std::isnan(value);
        if (there && !known && std::isnan(rates_[c][i]))
          unknown_[c][i] = 1;
        if (criterion.isDose()) {
          // Of rates at both ends; where one is not known, the other one.
          const double before = rates_[c][i];
          const double rate = !there || (!known && std::isnan(before)) ? 0
                              : !known                                 ? before
                              : std::isnan(before)                     ? value
                                                                       : 0.5 * (before + value);
          values_[c][i] += rate * passed;
          compared[i] = values_[c][i];
        } else {
          values_[c][i] = compared[i] = value;
        }
        rates_[c][i] = value;
        double& worst = worst_[c][i];
        if (std::isnan(worst)) {
          worst = compared[i];
        } else if (!std::isnan(compared[i])) {
          worst = criterion.falling ? std::min(worst, compared[i]) : std::max(worst, compared[i]);
        }
      }
    });
    watches_[c].update(time, compared);
  }
  last_ = time;
  begun_ = true;
  return {};
}

}  // namespace volute
