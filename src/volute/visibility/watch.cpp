// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/watch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <span>

#include "volute/base/content_hash.hpp"
#include "volute/base/plain_number.hpp"
#include "volute/base/write_file.hpp"
#include "volute/report/csv_cell.hpp"
#include "volute/report/line_plot.hpp"
#include "volute/visibility/plan_tenability.hpp"
#include "volute/visibility/verdict.hpp"

namespace volute {
namespace {

/// One for each; null: not until the end, or not known.
Json timesOf(std::span<const double> times) {
  Json list = Json::array();
  for (const double time : times) list.push_back(jsonNumber(time));
  return list;
}

Json asList(std::span<const Json> values) {
  return Json(std::vector<Json>(values.begin(), values.end()));
}

/// Criteria, with when each of the exposed reaches them and what they have taken in.
Json exposureJson(const ExposureMeter& meter, RoundTime round) {
  Json list = criteriaJson(meter);
  for (std::size_t c = 0; c < meter.criteria().size(); ++c) {
    const LossTimes& times = meter.times(c);
    std::vector<double> worst(meter.worst(c).begin(), meter.worst(c).end());
    for (std::size_t i = 0; i < worst.size(); ++i) {
      if (meter.unknown(c, i))
        worst[i] = std::numeric_limits<double>::quiet_NaN();
    }
    addTimes(list[c], "times", times, round, asList);
    list[c].update(
        Json{{"times_interpolated", timesOf(times.answers(RoundTime::kNone))},
             {"times_up", timesOf(times.answers(RoundTime::kUp))},
             {meter.criteria()[c].isDose() ? "dose_at_the_end" : "worst_value", timesOf(worst)}});
    if (const LossTimes* latest = meter.latest(c))
      list[c]["times_latest"] = timesOf(latest->answers(round));
    if (const auto allowed = meter.worstAllowed(c); !allowed.empty()) {
      for (std::size_t i = 0; i < worst.size(); ++i)
        worst[i] = meter.unknown(c, i) ? std::numeric_limits<double>::quiet_NaN() : allowed[i];
      list[c][meter.criteria()[c].isDose() ? "dose_at_most" : "worst_value_at_most"] =
          timesOf(worst);
    }
  }
  return list;
}

/// Points or people, as a verdict names them.
struct Exposed {
  std::string single, many;                                   ///< "person", "people"
  std::function<std::string(std::size_t)> one;                ///< "person 7"
  std::function<Vec3(std::size_t one, double time)> placeOf;  ///< NaN: not there
};

/// When the first of them reaches any criterion, and each; what nobody reaches, with the worst of
/// all.
/// @param sight  losses of sight of all signs, and where one is seen at all
/// @param latestSight  the same by the least smoke that the data allow
Json exposureVerdict(const ExposureMeter& meter, const Survey& survey, const Exposed& exposed,
                     const CountedLoss& sight, const CountedLoss& latestSight) {
  const double end = survey.end;
  std::size_t count = 0;
  std::vector<CountedLoss> losses, latest;
  std::vector<std::string> names;
  std::string missing;
  Json notAssessed = Json::array();
  const auto add = [](std::string& list, const std::string& name) {
    list += (list.empty() ? "" : ", ") + name;
  };
  const auto leaveOut = [&](const std::string& name, const char* why) {
    add(missing, name + why);
    notAssessed.push_back(name);
  };
  const auto seeing =
      survey.signs.empty() ? std::ptrdiff_t{0} : std::ranges::count(*sight.counts, true);
  if (!survey.signs.empty())
    count = sight.times->up.size();
  if (seeing > 0) {
    losses.push_back(sight);
    latest.push_back(latestSight);
    names.emplace_back("sight of signs");
  } else if (!survey.signs.empty()) {
    leaveOut("sight of signs", " (none is in sight, smoke or not)");
  }
  for (const ExposureMeter::Missing& one : meter.missing()) leaveOut(one.criterion.name, "");
  for (std::size_t c = 0; c < meter.criteria().size(); ++c) {
    count = meter.worst(c).size();
    if (!meter.isAssessed(c)) {
      leaveOut(meter.criteria()[c].name, " (not stored there)");
      continue;
    }
    losses.push_back({&meter.times(c)});
    latest.push_back({meter.latest(c) != nullptr ? meter.latest(c) : &meter.times(c)});
    names.push_back(meter.criteria()[c].name);
  }
  const std::string all = fmt::format("{} {}", count, count == 1 ? exposed.single : exposed.many);
  const auto who = [&](const FirstLoss& first) {
    const Vec3 place = exposed.placeOf(first.place, first.none);
    return exposed.one(first.place) + (place.allFinite() ? ", at " + placeWords(place) : "");
  };
  const auto sayUnknown = [&](const FirstLoss& first) {
    return unknownWords(first, "reached", "the " + exposed.many);
  };
  const auto asJson = [&](const std::string& name, const std::string& text,
                          const FirstLoss& first) {
    std::vector<Vec3> places(count, Vec3::Zero());
    if (first.any)
      places[first.place] = exposed.placeOf(first.place, first.none);
    Json json = verdictJson(name, text, first, survey.round, places);
    if (first.any)
      json["first"] = exposed.one(first.place);
    return json;
  };
  Json verdict = Json::array();
  std::vector<int> which;
  const LossTimes together = firstOf(losses, survey.round, &which);
  const FirstLoss first = firstLoss(together, survey.round);
  const FirstLoss late = firstLoss(firstOf(latest, survey.round), survey.round);
  const std::string by = first.any ? names[static_cast<std::size_t>(which[first.place])] : "";
  std::string text = fmt::format("ASET of all criteria, {}: ", all);
  if (losses.empty()) {
    text += "not known";
  } else if (!first.certain()) {
    std::string because;
    for (std::size_t n = 0; n < losses.size(); ++n) {
      if (!firstLoss(*losses[n].times, survey.round).certain())
        add(because, names[n]);
    }
    text += fmt::format("{}, because of {}", sayUnknown(first), because);
    if (first.any)
      text += fmt::format("; it is at the latest {} s, by {}, of {}", plainNumber(first.up, 4), by,
                          who(first));
  } else if (first.any) {
    text += fmt::format("{}, by {}, of {}; {} of them reach one by {} s",
                        timeWords(first, survey.round), by, who(first), percentWords(first.share),
                        plainNumber(end));
  } else {
    text += fmt::format("none is reached until {} s", plainNumber(end));
  }
  text += "." + latestWords(first, late, "reached");
  if (!missing.empty())
    text += fmt::format(" Not assessed: {}.", missing);
  verdict.push_back(asJson("all", text, first));
  verdict.back()["time_latest"] = latestJson(late, survey.round);
  if (first.any)
    verdict.back()["by"] = by;
  verdict.back()["not_assessed"] = std::move(notAssessed);
  if (seeing > 0) {
    const FirstLoss one = firstLoss(*sight.times, survey.round, *sight.counts);
    const FirstLoss last = firstLoss(*latestSight.times, survey.round, *latestSight.counts);
    const std::string them =
        fmt::format("those with one in sight without smoke ({} of {})", seeing, all);
    text = "Sight of signs is ";
    if (!one.certain()) {
      text += unknownWords(one, "lost", them);
      if (one.any)
        text +=
            fmt::format("; lost at the latest at {} s, by {}", plainNumber(one.up, 4), who(one));
    } else if (one.any) {
      text +=
          fmt::format("first lost at {}, by {}; by {} s by {} of {}", timeWords(one, survey.round),
                      who(one), plainNumber(end), percentWords(one.share), them);
    } else {
      text += fmt::format("lost by none of {} until {} s", them, plainNumber(end));
    }
    text += "." + latestWords(one, last, "lost");
    verdict.push_back(asJson("sight of signs", text, one));
    verdict.back()["time_latest"] = latestJson(last, survey.round);
  }
  for (std::size_t c = 0; c < meter.criteria().size(); ++c) {
    if (!meter.isAssessed(c))
      continue;
    const Criterion& criterion = meter.criteria()[c];
    const FirstLoss one = firstLoss(meter.times(c), survey.round);
    text = criterion.words() + " is ";
    if (!one.certain()) {
      text += sayUnknown(one);
      if (const std::string unread = meter.unread(c); !unread.empty())
        text += fmt::format(" (not all that is stored can be read: {})", unread);
      if (one.any)
        text +=
            fmt::format("; reached at the latest at {} s, by {}", plainNumber(one.up, 4), who(one));
    } else if (one.any) {
      text += fmt::format("first reached at {}, by {}; by {} s by {} of the {}",
                          timeWords(one, survey.round), who(one), plainNumber(end),
                          percentWords(one.share), exposed.many);
    } else {
      text += fmt::format("reached by none of {} until {} s", all, plainNumber(end));
      const auto worst = meter.worst(c);
      const auto most = std::ranges::max_element(worst, {}, [&](double value) {
        return std::isnan(value)   ? -std::numeric_limits<double>::infinity()
               : criterion.falling ? -value
                                   : value;
      });
      const std::string unit = criterion.unit();
      text += fmt::format("; the worst is {:.3g}{}{}, of {}", *most, unit.empty() ? "" : " ", unit,
                          exposed.one(static_cast<std::size_t>(most - worst.begin())));
    }
    text += '.';
    Json latestTime;
    if (meter.latest(c) != nullptr) {
      const FirstLoss last = firstLoss(*meter.latest(c), survey.round);
      text += latestWords(one, last, "reached");
      latestTime = latestJson(last, survey.round);
    }
    verdict.push_back(asJson(criterion.name, text + assumedWords(meter, c), one));
    if (meter.latest(c) != nullptr)
      verdict.back()["time_latest"] = std::move(latestTime);
  }
  return verdict;
}

/// Points of a file, or people who walk. Gives sight.csv and figures, no page.
class PointWatch : public Watch {
 public:
  PointWatch(std::vector<Vec3> points, std::vector<std::string> names)
      : points_(std::move(points)), names_(std::move(names)) {}

  Status begin(const Survey& survey, const SightSnapshot& first, Progress& progress) override {
    survey_ = &survey;
    constexpr std::uint64_t kPoint = 400, kPointOfCriterion = 80;  // in tables and the report
    AirField air;
    if (!survey.criteria.empty())
      air = AirField::open(*survey.field, survey.criteria, survey.times.front());
    VOLUTE_TRY(survey.checkMemory(points_.size(),
                                  kPoint + survey.criteria.size() * kPointOfCriterion +
                                      survey.sets.size() * SignLoss::kBytesOfSet +
                                      survey.signs.size() * SignLoss::kBytesOfSign +
                                      ExposureMeter::bytesOfPerson(air, survey.criteria, true)));
    std::vector<Place> places(points_.size());
    first.places(points_, places);
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (places[i] != Place::kGas) {
        progress.remark(
            {RemarkCode::kDoubtful,
             fmt::format("eye {} at {}, {}, {} m is {}", nameOf(i), plainNumber(points_[i][0]),
                         plainNumber(points_[i][1]), plainNumber(points_[i][2]),
                         places[i] == Place::kSolid ? "inside something solid"
                                                    : "where the case has no smoke")});
      }
    }
    std::vector<std::vector<std::size_t>> sets;
    for (const SignSet& set : survey.sets) sets.push_back(set.members);
    losses_.emplace(survey.signs, std::move(sets), points_.size());
    if (!survey.criteria.empty())
      meter_.emplace(std::move(air), survey.criteria, points_.size());
    if (meter_ ? meter_->air().smokeIsLate() : survey.beginsBefore())
      losses_->loseAll();
    return {};
  }

  std::vector<Vec3> eyes(double) const override { return points_; }

  Status take(const SurveyTime& at) override {
    losses_->update(at.time, at.sightings);
    if (!meter_ || !at.stored)
      return {};
    return advance(at.time, {at.extinctionHigh, at.extinctionLow});
  }

  Result<std::string> finish(Json& report) override {
    if (survey_->endsAfter())
      VOLUTE_TRY(goOn());
    report["eyes"] = {{"kind", "points"}, {"count", points_.size()}};
    if (!names_.empty())
      report["eyes"]["names"] = names_;
    report["aset"] = Json::array();
    for (std::size_t set = 0; set < survey_->sets.size(); ++set) {
      const LossTimes loss = losses_->times(set);
      Json json = {{"set", survey_->sets[set].name},
                   {"times_interpolated", timesOf(loss.answers(RoundTime::kNone))},
                   {"times_up", timesOf(loss.answers(RoundTime::kUp))},
                   {"times_earliest", timesOf(losses_->earliest(set).answers(survey_->round))},
                   {"times_latest", timesOf(losses_->latest(set).answers(survey_->round))},
                   {"in_sight", losses_->inSight(set)}};
      addTimes(json, "times", loss, survey_->round, asList);
      report["aset"].push_back(std::move(json));
    }
    report["sources"] = sourcesJson(*survey_, meter_ ? &*meter_ : nullptr);
    if (meter_) {
      const LossTimes sight = losses_->earliest(0), latest = losses_->latest(0);
      const std::vector<bool> inSight = losses_->inSight(0);
      report["verdict"] =
          exposureVerdict(*meter_, *survey_,
                          {"point", "points", [&](std::size_t i) { return "point " + nameOf(i); },
                           [&](std::size_t i, double) { return points_[i]; }},
                          {&sight, &inSight}, {&latest, &inSight});
      report["tenability"]["criteria"] = exposureJson(*meter_, survey_->round);
      std::string head = "time,x,y,z";
      for (std::size_t c = 0; c < meter_->criteria().size(); ++c) {
        const std::string name = Survey::fileName(meter_->criteria()[c].name);
        head.append(",").append(name);
        if (!meter_->valuesAllowed(c).empty())
          head.append(",").append(name).append("_at_worst");
      }
      if (areNamed())
        head += ",name";
      VOLUTE_TRY(writeFile(survey_->folder / "tenability.csv", head + "\n" + table_));
    }
    return std::string();
  }

  double end() const override { return meter_ ? meter_->air().end() : Watch::end(); }

  bool hasPage() const override { return false; }

 private:
  bool areNamed() const {
    return std::ranges::any_of(names_, [](const std::string& name) { return !name.empty(); });
  }

  /// "2", "2 (door)".
  std::string nameOf(std::size_t point) const {
    const bool named = !names_.empty() && !names_[point].empty();
    return fmt::format("{}{}", point + 1, named ? fmt::format(" ({})", names_[point]) : "");
  }

  /// Through the times at which the air is stored but no smoke.
  Status goOn() {
    losses_->loseRest();
    if (!meter_)
      return {};
    meter_->loseSmoke();
    std::vector<double> times = meter_->air().timesBetween(survey_->times.back(), survey_->end);
    times.push_back(survey_->end);
    for (const double time : times) VOLUTE_TRY(advance(time, {}));
    return {};
  }

  Status advance(double time, const ExposureMeter::Smoke& smoke) {
    VOLUTE_TRY(meter_->advance(
        time, [&](double, std::span<Vec3> places) { std::ranges::copy(points_, places.begin()); },
        smoke));
    for (std::size_t i = 0; i < points_.size(); ++i) {
      table_ += fmt::format("{:.10g},{:.10g},{:.10g},{:.10g}", time, points_[i][0], points_[i][1],
                            points_[i][2]);
      for (std::size_t c = 0; c < meter_->criteria().size(); ++c) {
        const bool lost = meter_->criteria()[c].isDose() && meter_->unknown(c, i);
        for (const auto& values : {meter_->values(c), meter_->valuesAllowed(c)}) {
          if (!values.empty())
            table_ += lost || std::isnan(values[i]) ? "," : fmt::format(",{:.9g}", values[i]);
        }
      }
      if (areNamed())
        table_.append(",").append(csvCell(names_[i]));
      table_ += '\n';
    }
    return {};
  }

  const Survey* survey_ = nullptr;
  std::vector<Vec3> points_;
  std::vector<std::string> names_;  // of each, or none
  std::optional<SignLoss> losses_;
  std::optional<ExposureMeter> meter_;
  std::string table_;  // lines of tenability.csv
};

/// When smoke hides from people on their way every sign that they would see without it. While
/// nothing but walls is in their way, or they are not there, they lose none.
class SightOnTheWay {
 public:
  explicit SightOnTheWay(std::size_t people)
      : earliest_(people, 1), middle_(people, 1), latest_(people, 1), inSight_(people, false) {}

  /// @param sightings  of all signs, `stride` apart
  void note(std::size_t person, double now, const Sighting* sightings, std::size_t signs,
            std::size_t stride) {
    Share worst, middle, best;
    for (std::size_t s = 0; s < signs; ++s) {
      const Sighting& one = sightings[s * stride];
      if (one.blocked || !(one.limit > 0))
        continue;
      worst.add(one, one.high);
      middle.add(one, one.depth);
      best.add(one, one.low);
      inSight_[person] = true;
    }
    earliest_.note(person, now, worst.value(), {now, now});
    middle_.note(person, now, middle.value(), {now, now});
    latest_.note(person, now, best.value(), {now, now});
  }

  /// Nothing is known of somebody any more.
  void lose(std::size_t person) {
    for (LevelWatch* watch : {&earliest_, &middle_, &latest_}) watch->lose(person);
  }

  const LossTimes& earliest() const { return earliest_.times(); }

  const LossTimes& times() const { return middle_.times(); }

  const LossTimes& latest() const { return latest_.times(); }

  /// Who has had a sign in sight.
  const std::vector<bool>& inSight() const { return inSight_; }

 private:
  /// How much of the depth at which a sign is lost lies in front of the one that is seen best.
  class Share {
   public:
    void add(const Sighting& sighting, double depth) {
      any_ = true;
      if (sighting.covered)
        share_ = std::min(share_, depth / sighting.limit);
      else
        perhaps_ |= sighting.low <= sighting.limit;
    }

    /// Above 1: no sign is seen; NaN: not known.
    double value() const {
      if (!any_ || share_ <= 1)
        return any_ ? share_ : 0;
      return perhaps_ ? std::numeric_limits<double>::quiet_NaN() : share_;
    }

   private:
    bool any_ = false, perhaps_ = false;
    double share_ = std::numeric_limits<double>::infinity();
  };

  LevelWatch earliest_, middle_, latest_;
  std::vector<bool> inSight_;
};

class TrajectoryWatch final : public Watch {
 public:
  explicit TrajectoryWatch(Trajectories people) : people_(std::move(people)) {}

  bool moves() const override { return true; }

  Status begin(const Survey& survey, const SightSnapshot& first, Progress& progress) override {
    survey_ = &survey;
    progress_ = &progress;
    noteFloor(first);
    if (people_.end() < survey.times.front() || people_.begin() > survey.times.back()) {
      progress.remark(
          {RemarkCode::kDoubtful,
           fmt::format("people walk from {} to {} s, the smoke is there from {} to {} s: "
                       "nobody looks",
                       plainNumber(people_.begin()), plainNumber(people_.end()),
                       plainNumber(survey.times.front()), plainNumber(survey.times.back()))});
    }
    if (!survey.criteria.empty()) {
      meter_.emplace(AirField::open(*survey.field, survey.criteria), survey.criteria,
                     people_.ids().size());
    }
    sight_.emplace(people_.ids().size());
    const double start = survey.times.front();
    for (const auto& [id, span] : people_.spans()) {
      for (const double time : {span.from, span.until}) turns_.push_back({time, placeOf(id)});
      if (span.from < start && !isAt(start, span.from))
        lose(placeOf(id));
    }
    std::ranges::sort(turns_, {}, &ExposureMeter::Turn::time);
    return {};
  }

  std::vector<Vec3> eyes(double time) const override {
    std::vector<Vec3> eyes;
    for (const auto& person : people_.at(time)) eyes.push_back(person.eye);
    return eyes;
  }

  bool wantsChanges() const override { return false; }

  bool wantsExtinction() const override { return true; }

  /// Where people are between a stored time and its neighbours, one time after the other.
  std::vector<Vec3> passed(double time) const override {
    std::vector<Vec3> all;
    if (survey_->criteria.empty())
      return all;
    std::vector<Vec3> places(people_.ids().size());
    for (const bool after : {false, true}) {
      for (const double at : timesBeside(time, after)) {
        placesAt(at, places);
        all.insert(all.end(), places.begin(), places.end());
      }
    }
    return all;
  }

  Status take(const SurveyTime& at) override {
    const auto people = people_.at(at.time);
    for (std::size_t i = 0; i < at.extinction.size(); ++i) {
      if (std::isnan(at.extinction[i]))
        outside_.insert(people[i].id);
    }
    Json record = {{"time", at.time}, {"people", people.size()}, {"see_a_sign", 0}};
    Json ids = Json::array();
    for (std::size_t i = 0; i < people.size(); ++i) {
      bool any = false;
      for (std::size_t s = 0; s < survey_->signs.size(); ++s)
        any |= at.sightings[s * people.size() + i].visible;
      sight_->note(placeOf(people[i].id), at.time, &at.sightings[i], survey_->signs.size(),
                   people.size());
      if (any)
        record["see_a_sign"] = record["see_a_sign"].get<int>() + 1;
      ids.push_back(people[i].id);
    }
    record["ids"] = std::move(ids);
    records_.push_back(std::move(record));
    return meter_ ? expose(at) : Status();
  }

  /// Extinctions where people were at the last time, and on the way since, as it was then.
  struct OnTheWay {
    std::vector<double> last, since;
  };

  /// Doses along the ways since the time before.
  Status expose(const SurveyTime& at) {
    constexpr double kAbsent = -1;
    const std::size_t count = people_.ids().size();
    const auto people = people_.at(at.time);
    const auto before = timesBeside(at.time, false);
    std::vector<double> passing{lastTime_};
    passing.insert(passing.end(), before.begin(), before.end());
    passing.push_back(at.time);
    // At each of these times since the one before: the smoke is linear in time at each place.
    std::vector<Vec3> places(count);
    const auto follow = [&](OnTheWay& way, std::span<const double> now,
                            std::span<const double> passed) {
      std::vector<std::vector<double>> smoke{std::move(way.last)};
      for (std::size_t m = 0; m < before.size(); ++m) {
        const double share = (before[m] - lastTime_) / (at.time - lastTime_);
        std::vector<double>& then = smoke.emplace_back(count, kAbsent);
        placesAt(before[m], places);
        for (std::size_t i = 0; i < count; ++i) {
          if (!std::isnan(places[i].x()))
            then[i] = mixed(way.since[m * count + i], passed[m * count + i], share);
        }
      }
      std::vector<double>& last = smoke.emplace_back(count, kAbsent);
      for (std::size_t i = 0; i < people.size(); ++i)  // the least is no number either then
        last[placeOf(people[i].id)] =
            std::isnan(at.extinctionHigh[i]) ? at.extinctionHigh[i] : now[i];
      way.last = last;
      way.since.assign(passed.begin() + static_cast<std::ptrdiff_t>(before.size() * count),
                       passed.end());
      return smoke;
    };
    const auto most = follow(most_, at.extinctionHigh, at.passedHigh);
    const auto least = follow(least_, at.extinctionLow, at.passedLow);
    const auto between = [&](double time, std::span<double> mostOut, std::span<double> leastOut) {
      const auto next =
          static_cast<std::size_t>(std::ranges::lower_bound(passing, time) - passing.begin());
      const std::size_t n = std::clamp<std::size_t>(next, 1, passing.size() - 1);
      const double share = (time - passing[n - 1]) / (passing[n] - passing[n - 1]);
      for (std::size_t i = 0; i < count; ++i) {
        for (const auto& [smoke, out] : {std::pair(&most, mostOut), std::pair(&least, leastOut)}) {
          const double early = (*smoke)[n - 1][i], late = (*smoke)[n][i];
          // Who comes or goes between two of these times is in the smoke of the other one.
          out[i] = early < 0 && late < 0 ? std::numeric_limits<double>::quiet_NaN()
                   : early < 0           ? late
                   : late < 0            ? early
                                         : mixed(early, late, share);
        }
      }
    };
    VOLUTE_TRY(meter_->advance(
        at.time, [&](double time, std::span<Vec3> out) { placesAt(time, out); },
        {most.back(), least.back()}, kPassing, between, turns_));
    lastTime_ = at.time;
    return {};
  }

  /// Between a stored time and the one before, or after it.
  std::vector<double> timesBeside(double time, bool after) const {
    constexpr double kMax = 1e6;  // places at a time
    const auto& times = survey_->times;
    const auto here = std::ranges::lower_bound(times, time) - times.begin();
    const auto n = static_cast<std::size_t>(here);
    if (after ? n + 1 >= times.size() : n == 0)
      return {};
    const double from = after ? time : times[n - 1], to = after ? times[n + 1] : time;
    const double people = static_cast<double>(people_.ids().size());
    const auto pieces =
        static_cast<int>(std::min(std::ceil((to - from) / kPassing), std::max(1.0, kMax / people)));
    std::vector<double> passing;
    for (int i = 1; i < pieces; ++i) passing.push_back(from + (to - from) * i / pieces);
    return passing;
  }

  /// Eyes of which all are where feet would be.
  void noteFloor(const SightSnapshot& first) {
    constexpr double kLow = 0.3;          // [m]
    constexpr std::size_t kEnough = 100;  // of people, evenly spread
    const auto spans = people_.spans();
    std::vector<Vec3> eyes, below, above, at(people_.ids().size());
    for (std::size_t i = 0; i < std::min(kEnough, spans.size()); ++i) {
      const auto& [id, span] = spans[i * spans.size() / std::min(kEnough, spans.size())];
      placesAt(span.from, at);
      eyes.push_back(at[placeOf(id)]);
      below.push_back(eyes.back() - Vec3(0, 0, kLow));
      above.push_back(eyes.back() + Vec3(0, 0, kLow));
    }
    std::vector<Place> here(eyes.size()), there(here), over(here);
    first.places(eyes, here);
    first.places(below, there);
    first.places(above, over);  // smoke in a layer alone ends on both sides
    std::size_t people = 0, low = 0;
    for (std::size_t i = 0; i < eyes.size(); ++i) {
      const bool isInside = here[i] == Place::kGas && over[i] == Place::kGas;
      people += isInside ? 1 : 0;
      low += isInside && there[i] != Place::kGas ? 1 : 0;
    }
    if (people == 0 || low < people)
      return;
    progress_->remark(
        {RemarkCode::kDoubtful,
         fmt::format(
             "all people's eyes are less than {:g} m above a floor, where smoke comes last: "
             "is their z the floor's? In a table, name its column floor",
             kLow),
         {Hint::set("height")}});
  }

  /// Those who are there before the first time, or after the last one.
  void noteEnds() {
    const double first = survey_->times.front(), last = survey_->times.back();
    std::size_t longer = 0;
    for (const auto& [id, span] : people_.spans()) {
      const bool before = span.from < first && !isAt(first, span.from);
      const bool after = span.until > last && !isAt(last, span.until);
      longer += before || after ? 1 : 0;
      if (after)
        lose(placeOf(id));
    }
    if (longer > 0) {
      progress_->remark(
          {RemarkCode::kDoubtful,
           fmt::format("{} of {} people are on their way before {} s or "
                       "after {} s, where the smoke is not "
                       "known: what they see and take in then is not",
                       longer, people_.people(), plainNumber(first), plainNumber(last))});
    }
  }

  /// Nothing is known of somebody from now on.
  void lose(std::size_t person) {
    sight_->lose(person);
    if (meter_)
      meter_->lose(person);
  }

  /// Whether a time is one of the stored ones, rounding aside.
  bool isAt(double stored, double time) const {
    const auto place = storedPlace(survey_->times, time);
    return place && place->span.from == stored && place->span.until == stored;
  }

  /// NaN for those who are not there.
  void placesAt(double time, std::span<Vec3> places) const {
    std::ranges::fill(places, Vec3::Constant(std::numeric_limits<double>::quiet_NaN()));
    for (const auto& person : people_.at(time)) places[placeOf(person.id)] = person.eye;
  }

  std::size_t placeOf(int id) const {
    return static_cast<std::size_t>(std::ranges::lower_bound(people_.ids(), id) -
                                    people_.ids().begin());
  }

  Result<std::string> finish(Json& report) override {
    noteEnds();
    report["sources"] = sourcesJson(*survey_, meter_ ? &*meter_ : nullptr);
    if (!outside_.empty()) {
      progress_->remark(
          {RemarkCode::kDoubtful,
           fmt::format("{} of {} people are at some stored time inside something solid or where "
                       "the case has no smoke, the first of them {}: check their coordinates",
                       outside_.size(), people_.people(), *outside_.begin()),
           {Hint::set("height")}});
    }
    Json aset = {{"set", survey_->sets[0].name},
                 {"ids", people_.ids()},
                 {"in_sight", sight_->inSight()},
                 {"times_interpolated", timesOf(sight_->times().answers(RoundTime::kNone))},
                 {"times_up", timesOf(sight_->times().answers(RoundTime::kUp))},
                 {"times_earliest", timesOf(sight_->earliest().answers(survey_->round))},
                 {"times_latest", timesOf(sight_->latest().answers(survey_->round))}};
    addTimes(aset, "times", sight_->times(), survey_->round, asList);
    report["aset"] = Json::array({std::move(aset)});
    if (meter_) {
      report["tenability"]["ids"] = std::vector<int>(people_.ids().begin(), people_.ids().end());
      report["tenability"]["criteria"] = exposureJson(*meter_, survey_->round);
      report["verdict"] = exposureVerdict(
          *meter_, *survey_,
          {"person", "people",
           [&](std::size_t i) { return fmt::format("person {}", people_.ids()[i]); },
           [&](std::size_t i, double time) {
             std::vector<Vec3> places(people_.ids().size());
             placesAt(time, places);
             return places[i];
           }},
          {&sight_->earliest(), &sight_->inSight()}, {&sight_->latest(), &sight_->inSight()});
    }
    report["eyes"] = {{"kind", "trajectories"},
                      {"people", people_.people()},
                      {"begin", people_.begin()},
                      {"end", people_.end()}};
    report["people"] = records_;
    std::vector<double> times;
    PlotLine there{"people", {}}, seeing{"see a sign", {}};
    for (const Json& record : records_) {
      times.push_back(record["time"].get<double>());
      there.y.push_back(record["people"].get<double>());
      seeing.y.push_back(record["see_a_sign"].get<double>());
    }
    std::string page;
    if (times.size() > 1) {
      page = linePlot("People on their way, and those who see a sign", "time [s]", "people", times,
                      {there, seeing});
    }
    if (meter_)
      page += criteriaTable(*meter_);
    return page + sourcesTable(report["sources"]);
  }

 private:
  static constexpr double kPassing = 0.5;  // [s], some steps of somebody who runs

  const Survey* survey_ = nullptr;
  Progress* progress_ = nullptr;
  std::vector<ExposureMeter::Turn> turns_;
  double lastTime_ = 0;
  OnTheWay most_, least_;
  std::set<int> outside_;  // who was at some time where there is no gas
  std::optional<ExposureMeter> meter_;
  std::optional<SightOnTheWay> sight_;
  Trajectories people_;
  Json records_ = Json::array();
};

}  // namespace

bool Survey::pictured(std::size_t time) const {
  if (maps == Maps::kNone || time >= times.size())
    return false;
  if (maps == Maps::kAll || times.size() <= kPicturedTimes)
    return true;
  // The n-th of them is at n (times - 1) / (pictured - 1), rounded down.
  const std::size_t last = times.size() - 1, steps = kPicturedTimes - 1;
  const std::size_t n = (time * steps + last - 1) / last;  // the first that is not before `time`
  return n * last / steps == time;
}

Status Survey::checkMemory(std::uint64_t eyes, std::uint64_t kept) const {
  const std::uint64_t need = eyes * (bytesOfLine * signs.size() + kept);
  if (need <= maxMemory)
    return {};
  return fail(ErrorCode::kTooLarge,
              "{} eyes and {} signs need about {} MiB, more than the {} MiB allowed; choose places "
              "farther apart, fewer signs, or more memory",
              eyes, signs.size(), need >> 20, maxMemory >> 20);
}

std::string Survey::fileName(std::string_view name) {
  std::string file;
  for (const char c : name) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       c == '-' || c == '_';
    file += plain ? c : '_';
  }
  constexpr std::size_t kLongest = 100;  // other parts of a file's name have room beside it
  if (file.size() <= kLongest)
    return file;
  ContentHash hash;
  hash.add(std::span(name.data(), name.size()));
  return fmt::format("{}_{}", file.substr(0, kLongest - 9), hash.digits().substr(0, 8));
}

std::unique_ptr<Watch> pointWatch(std::vector<Vec3> points, std::vector<std::string> names) {
  return std::make_unique<PointWatch>(std::move(points), std::move(names));
}

std::unique_ptr<Watch> trajectoryWatch(Trajectories people) {
  return std::make_unique<TrajectoryWatch>(std::move(people));
}

}  // namespace volute
