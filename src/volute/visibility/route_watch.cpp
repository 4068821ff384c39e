// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <unordered_set>

#include "volute/base/number_word.hpp"
#include "volute/base/plain_number.hpp"
#include "volute/io/image_file.hpp"
#include "volute/report/line_plot.hpp"
#include "volute/report/page.hpp"
#include "volute/visibility/exposure_meter.hpp"
#include "volute/visibility/plan_picture.hpp"
#include "volute/visibility/plan_tenability.hpp"
#include "volute/visibility/plan_use.hpp"
#include "volute/visibility/verdict.hpp"
#include "volute/visibility/watch.hpp"

namespace volute {
namespace {

/// A point of a route.
struct Station {
  std::size_t route = 0;
  double along = 0;    ///< [m] from the route's start
  double share = 0;    ///< of the route's length that it stands for
  double arrival = 0;  ///< when a walker is there [s]
};

/// Where a walker is at a time.
struct TrackPoint {
  double time = 0;   ///< [s]
  double along = 0;  ///< [m] from the route's start
};

constexpr double kNotYet = std::numeric_limits<double>::infinity();

class RouteWatch final : public Watch {
 public:
  RouteWatch(std::vector<Route> routes, const Walk& walk)
      : routes_(std::move(routes)), walking_(walk) {
    unsure_.resize(routes_.size());
    if (walk.start.waits()) {
      tracks_.resize(routes_.size());
      starts_.assign(routes_.size(), kNotYet);
    } else {
      tracks_.assign(routes_.size(), {{walk.start.time, 0.0}});
      starts_.assign(routes_.size(), walk.start.time);
    }
  }

  Status begin(const Survey& survey, const SightSnapshot& first, Progress& progress) override {
    survey_ = &survey;
    VOLUTE_TRY(checkSigns());
    firstStations_ = {0};
    for (std::size_t r = 0; r < routes_.size(); ++r) {
      addStations(r);
      firstStations_.push_back(stations_.size());
      if (routes_[r].level)
        standOnFloors(first, survey.bounds, routes_[r].points.front().z(),
                      std::span(eyes_).subspan(firstStations_[r]), progress);
    }
    VOLUTE_TRY(checkMemory());
    std::vector<Place> places(eyes_.size());
    first.places(eyes_, places);
    const auto lost =
        std::ranges::count_if(places, [](Place place) { return place != Place::kGas; });
    if (lost == static_cast<std::ptrdiff_t>(eyes_.size())) {
      return failFor("route", ErrorCode::kInvalidArgument, Hint::set("height"),
                     "no point of the routes is where the case has smoke, {} .. {}, {} "
                     ".. {}, {} .. {} m; check the coordinates",
                     plainNumber(survey.bounds.min[0]), plainNumber(survey.bounds.max[0]),
                     plainNumber(survey.bounds.min[1]), plainNumber(survey.bounds.max[1]),
                     plainNumber(survey.bounds.min[2]), plainNumber(survey.bounds.max[2]));
    }
    if (lost > 0)
      progress.remark(
          {RemarkCode::kDoubtful, fmt::format("{} of {} points of the routes are inside something "
                                              "solid or where the case has no smoke",
                                              lost, eyes_.size())});
    noteWalls(first, progress);
    // At the routes' own height, to draw them on.
    auto plan = floorPlan(first, survey.bounds, eyes_[0][2], survey.step);
    if (plan)
      plan_ = std::move(*plan);
    walk_.resize(stations_.size());
    if (!survey.criteria.empty()) {
      meter_.emplace(AirField::open(*survey.field, survey.criteria), survey.criteria,
                     routes_.size());
      const double start = walking_.start.time;
      if (!walking_.start.waits() && start < survey.times.front() &&
          !storedPlace(survey.times, start)) {
        progress.remark(fmt::format(
            "the walk starts at {} s, before the first stored time, {} s: what walkers take in "
            "is not known",
            plainNumber(start), plainNumber(survey.times.front())));
        for (std::size_t r = 0; r < routes_.size(); ++r) meter_->lose(r);
      }
    }
    return {};
  }

  std::vector<Vec3> eyes(double) const override { return eyes_; }

  bool wantsExtinction() const override { return mindsSmoke(); }

  Status take(const SurveyTime& at) override {
    if (mindsSmoke())
      walkThroughSmoke(at);
    if (at.stored)
      noteCoverage(at);
    noteWalk(at);
    if (meter_ && at.stored)
      VOLUTE_TRY(expose(at));
    last_.assign(at.sightings.begin(), at.sightings.end());
    lastTime_ = at.time;
    return {};
  }

  Result<std::string> finish(Json& report) override {
    noteEnds();
    report["eyes"] = {{"kind", "routes"}, {"step", survey_->step}, {"count", eyes_.size()}};
    report["walk"] = {{"speed", walking_.speed}, {"start", walking_.start.time}};
    if (walking_.start.waits()) {
      report["walk"]["start"] = nullptr;
      report["walk"]["starts_when"] = {{"extinction", walking_.start.smoke},
                                       {"delay", walking_.start.delay},
                                       {"heard", walking_.start.heard}};
    }
    const SpeedLawInfo& law = infoOf(walking_.slowed);
    Json coefficients = Json::object();
    for (std::size_t i = 0; i < law.coefficients.size() && !walking_.slowed.isNone(); ++i)
      coefficients[std::string(law.coefficients[i])] = walking_.slowed.coefficients[i];
    report["walk"]["slowed_by_smoke"] = {{"law", law.name},
                                         {"coefficients", coefficients},
                                         {"source", speedSource()},
                                         {"source_checked", law.checked}};
    if (meter_)
      report["tenability"]["criteria"] = criteriaJson(*meter_);
    report["sources"] = sourcesJson(*survey_, meter_ ? &*meter_ : nullptr);
    report["routes"] = Json::array();
    std::string page = "<h2>Routes</h2>\n";
    if (plan_.size() > 0) {
      VOLUTE_TRY(drawRoutePlan());
      VOLUTE_ASSIGN(const auto figure,
                    htmlFigure(survey_->folder / "routes.png", "The routes and the signs."));
      page += figure;
    }
    for (std::size_t r = 0; r < routes_.size(); ++r) {
      report["routes"].push_back(routeJson(r));
      if (r < kPlots)
        page += routePlot(r);
    }
    if (routes_.size() > kPlots)
      page += fmt::format("<p>Plots of the first {} of {} routes; visibility.json has all.</p>\n",
                          kPlots, routes_.size());
    addVerdict(report);
    page += walkTable(report["routes"]);
    if (meter_)
      page += criteriaTable(*meter_);
    return page + sourcesTable(report["sources"]);
  }

 private:
  /// Whether where walkers are depends on the smoke.
  bool mindsSmoke() const { return !walking_.slowed.isNone() || walking_.start.waits(); }

  /// What the report has of each route, of each at each time, and of each station.
  Status checkMemory() const {
    constexpr std::uint64_t kRoute = 2500, kTime = 700, kTimeOfSign = 120, kStation = 700;
    const std::uint64_t ofRoute =
        kRoute + survey_->times.size() * (kTime + kTimeOfSign * survey_->signs.size());
    return survey_->checkMemory(eyes_.size(), kStation + ofRoute * routes_.size() / eyes_.size());
  }

  /// Signs belong to routes that are there.
  Status checkSigns() const {
    std::unordered_set<std::string_view> there;
    for (const Route& route : routes_) there.insert(route.name);
    for (const SightTarget& target : survey_->signs) {
      for (const std::string& name : target.sign.routes) {
        if (!there.contains(name)) {
          std::string names;
          for (const Route& route : routes_)
            names += (names.empty() ? "'" : ", '") + route.name + "'";
          return failFor("route", ErrorCode::kInvalidArgument,
                         "sign '{}' is for route '{}', which is not there; expected one of {}",
                         target.sign.name, name, names);
        }
      }
    }
    return {};
  }

  /// Whether a sign is for the walker of a route.
  bool isFor(std::size_t sign, std::size_t route) const {
    const auto& routes = survey_->signs[sign].sign.routes;
    return routes.empty() || std::ranges::find(routes, routes_[route].name) != routes.end();
  }

  /// Whether a sign is ahead of who walks past a station, and for them.
  bool isAhead(std::size_t sign, std::size_t station) const {
    const std::size_t r = stations_[station].route;
    const bool last = station + 1 == firstStations_[r + 1];
    const Vec3 way = last ? Vec3(eyes_[station] - eyes_[station - 1])
                          : Vec3(eyes_[station + 1] - eyes_[station]);
    return isFor(sign, r) &&
           way.head<2>().dot((survey_->signs[sign].target - eyes_[station]).head<2>()) >= 0;
  }

  std::string speedSource() const {
    const std::string source(infoOf(walking_.slowed).source);
    return isOwn(walking_.slowed)
               ? fmt::format("{}, the user's own coefficients, in the law of: {}",
                             fmt::join(walking_.slowed.coefficients, ", "), source)
               : source;
  }

  void addStations(std::size_t r) {
    const auto along = stationsOf(routes_[r], survey_->step);
    const double length = routes_[r].length();
    for (std::size_t i = 0; i < along.size(); ++i) {
      const double before = i > 0 ? along[i - 1] : along[i];
      const double after = i + 1 < along.size() ? along[i + 1] : along[i];
      stations_.push_back({r, along[i], 0.5 * (after - before) / length,
                           !mindsSmoke() ? starts_[r] + along[i] / walking_.speed
                           : i == 0      ? starts_[r]
                                         : kNotYet});
      eyes_.push_back(routes_[r].at(along[i]));
    }
  }

  /// Where routes lead through walls, at the first time.
  void noteWalls(const SightSnapshot& first, Progress& progress) const {
    for (std::size_t r = 0; r < routes_.size(); ++r) {
      std::vector<SightLine> lines;
      std::vector<double> from;
      for (std::size_t i = firstStations_[r] + 1; i < firstStations_[r + 1]; ++i) {
        lines.push_back({eyes_[i - 1], eyes_[i]});
        from.push_back(stations_[i - 1].along);
      }
      std::vector<Sight> sights(lines.size());
      first.look(lines, sights);
      const auto wall = std::ranges::find(sights, true, &Sight::blocked);
      if (wall != sights.end()) {
        progress.remark(fmt::format(
            "route '{}' leads through something solid, first about {:.3g} m from its start",
            routes_[r].name, from[static_cast<std::size_t>(wall - sights.begin())]));
      }
    }
  }

  /// How far the walker of a route is at a time [m]; NaN before the start, unless they wait there,
  /// and after the arrival.
  double alongAt(std::size_t r, double time) const {
    if (time < starts_[r])
      return walking_.start.waits() ? 0 : std::numeric_limits<double>::quiet_NaN();
    const double length = routes_[r].length();
    if (!mindsSmoke()) {
      const double along = (time - starts_[r]) * walking_.speed;
      return along <= length ? along : std::numeric_limits<double>::quiet_NaN();
    }
    const auto& track = tracks_[r];
    const auto next = std::ranges::lower_bound(track, time, {}, &TrackPoint::time);
    if (next == track.end())
      return std::numeric_limits<double>::quiet_NaN();
    if (next == track.begin())
      return next->along;
    const TrackPoint& before = *std::prev(next);
    const double share = (time - before.time) / (next->time - before.time);
    return before.along + share * (next->along - before.along);
  }

  /// Where the eyes of a route's walker are; NaN: nowhere.
  Vec3 placeAt(std::size_t r, double along) const {
    if (std::isnan(along))
      return Vec3::Constant(along);
    Vec3 place = routes_[r].at(along);
    for (std::size_t i = firstStations_[r] + 1; i < firstStations_[r + 1]; ++i) {
      const double from = stations_[i - 1].along, to = stations_[i].along;
      if (along > to && i + 1 < firstStations_[r + 1])
        continue;
      const double share = std::clamp((along - from) / (to - from), 0.0, 1.0);
      place.z() = (1 - share) * eyes_[i - 1].z() + share * eyes_[i].z();
      break;
    }
    return place;
  }

  /// Goes on to a time in small steps, each at the speed of the smoke where the walker is: linear
  /// in time between the two times that are known, and between stations.
  void walkThroughSmoke(const SurveyTime& at) {
    std::vector<double> extinction(at.extinction.begin(), at.extinction.end());
    if (extinction_.empty()) {
      extinction_ = extinction;
      smokeTime_ = at.time;
    }
    setOut(at.time, extinction);
    for (std::size_t r = 0; r < routes_.size(); ++r)
      walkOn(r, firstStations_[r], firstStations_[r + 1], at.time, extinction);
    extinction_ = std::move(extinction);
    smokeTime_ = at.time;
  }

  /// Those who wait see the smoke that is there by a time, or hear of it, and set out.
  void setOut(double until, std::span<const double> extinction) {
    const WalkStart& start = walking_.start;
    if (!start.waits())
      return;
    double anybody = kNotYet;
    for (std::size_t r = 0; r < routes_.size(); ++r) {
      const double before = extinction_[firstStations_[r]], now = extinction[firstStations_[r]];
      if (starts_[r] < kNotYet)
        continue;
      if (std::isnan(before + now)) {
        unsure_[r] = true;
      } else if (now >= start.smoke) {
        const double share = before < start.smoke ? (start.smoke - before) / (now - before) : 0;
        const double seen = smokeTime_ + share * (until - smokeTime_);
        starts_[r] = seen + start.delay;
        anybody = std::min(anybody, seen);
      }
    }
    for (std::size_t r = 0; r < routes_.size(); ++r) {
      if (start.heard && starts_[r] == kNotYet)
        starts_[r] = anybody + start.delay;
      else if (start.heard)
        starts_[r] = std::min(starts_[r], anybody + start.delay);
      if (tracks_[r].empty() && starts_[r] <= until) {
        tracks_[r] = {{starts_[r], 0.0}};
        stations_[firstStations_[r]].arrival = starts_[r];
      }
    }
  }

  void walkOn(std::size_t r, std::size_t first, std::size_t end, double until,
              std::span<const double> extinction) {
    constexpr double kStep = 0.1;  // [s]
    auto& track = tracks_[r];
    if (track.empty())
      return;
    const double length = routes_[r].length();
    const double passed = until - smokeTime_;
    std::size_t next = first;
    while (next < end && stations_[next].arrival < kNotYet) ++next;
    while (track.back().time < until && track.back().along < length && next < end) {
      const TrackPoint here = track.back();
      const double share = extinction_.empty() || !(passed > 0)
                               ? 1
                               : std::clamp((here.time - smokeTime_) / passed, 0.0, 1.0);
      const auto smokeAt = [&](std::size_t i) {
        return extinction_[i] + share * (extinction[i] - extinction_[i]);
      };
      const double from = stations_[next - 1].along, to = stations_[next].along;
      const double place = std::clamp((here.along - from) / (to - from), 0.0, 1.0);
      const double smoke = (1 - place) * smokeAt(next - 1) + place * smokeAt(next);
      unsure_[r] = unsure_[r] || std::isnan(smoke);  // as in clear air
      const double speed = walkingSpeed(walking_.slowed, walking_.speed, smoke);
      const double step = std::min({kStep, until - here.time, (to - here.along) / speed});
      const double along = here.along + speed * step;
      track.push_back({here.time + step, std::min(along, to)});
      if (to - along <= 1e-9 * length) {
        track.back().along = to;
        stations_[next++].arrival = here.time + step;
      }
    }
  }

  /// Of walkers who are still on their way after the last time, nothing more is known.
  void noteEnds() {
    if (!meter_)
      return;
    for (std::size_t r = 0; r < routes_.size(); ++r) {
      const double arrival = stations_[firstStations_[r + 1] - 1].arrival;
      if (arrival > survey_->times.back() && !storedPlace(survey_->times, arrival))
        meter_->lose(r);
    }
  }

  /// What walkers take in.
  Status expose(const SurveyTime& at) {
    const auto places = [&](double time, std::span<Vec3> out) {
      for (std::size_t r = 0; r < routes_.size(); ++r) out[r] = placeAt(r, alongAt(r, time));
    };
    // Between stations, and between the two times, the smoke is linear.
    // The least of what is not known, or of something solid, is not known either.
    std::vector<double> low(at.extinctionLow.begin(), at.extinctionLow.end());
    for (std::size_t i = 0; i < low.size(); ++i)
      low[i] = std::isnan(at.extinctionHigh[i]) ? at.extinctionHigh[i] : low[i];
    const double passed = at.time - smokeBefore_;
    const auto smokeAt = [&](double time, std::span<double> most, std::span<double> least) {
      const double late = passed > 0 && !highBefore_.empty() ? (time - smokeBefore_) / passed : 1;
      const auto stationAt = [&](std::size_t i, const std::vector<double>& before,
                                 std::span<const double> now) {
        return late < 1 ? mixed(before[i], now[i], late) : now[i];
      };
      std::ranges::fill(most, std::numeric_limits<double>::quiet_NaN());
      std::ranges::fill(least, std::numeric_limits<double>::quiet_NaN());
      for (std::size_t i = 1; i < stations_.size(); ++i) {
        const Station &from = stations_[i - 1], &to = stations_[i];
        const double along = alongAt(to.route, time);
        if (from.route != to.route || !(along >= from.along && along <= to.along))
          continue;
        const double share = (along - from.along) / (to.along - from.along);
        most[to.route] = mixed(stationAt(i - 1, highBefore_, at.extinctionHigh),
                               stationAt(i, highBefore_, at.extinctionHigh), share);
        least[to.route] =
            mixed(stationAt(i - 1, lowBefore_, low), stationAt(i, lowBefore_, low), share);
      }
    };
    std::vector<double> most(routes_.size()), least(routes_.size());
    smokeAt(at.time, most, least);
    constexpr double kStep = 0.25;  // [s]
    VOLUTE_TRY(meter_->advance(at.time, places, {most, least}, kStep, smokeAt));
    smokeBefore_ = at.time;
    highBefore_.assign(at.extinctionHigh.begin(), at.extinctionHigh.end());
    lowBefore_ = std::move(low);
    return {};
  }

  /// Of shares of the way on which a sign is seen, and on which it is known what is seen.
  static std::string seenWords(double seen, double known) {
    constexpr double kWhole = 1 - 1e-6;
    if (known <= 0)
      return "; whether a sign is in view is not known on the way";
    std::string words = fmt::format(" and has a sign in view on {:.0f} % of the way", 100 * seen);
    if (known < kWhole)
      words += fmt::format(", of which {} is known", percentWords(known));
    return words;
  }

  void addVerdict(Json& report) const {
    Json verdict = Json::array();
    for (std::size_t r = 0; r < routes_.size(); ++r) {
      const Json& route = report["routes"][r];
      std::string text =
          fmt::format("Route '{}': a person who {} ", routes_[r].name, startWords(r));
      text += route["arrival"].is_null()
                  ? fmt::format("has not arrived by {} s, the last stored time,",
                                plainNumber(survey_->times.back()))
                  : fmt::format("arrives at {} s{}", plainNumber(route["arrival"].get<double>(), 4),
                                unsure_[r] ? ", if there is no smoke where it is not known," : "");
      text += seenWords(route["walk_share_with_a_sign"].get<double>(),
                        route["walk_share_known"].get<double>());
      Json json = {{"criterion", "route " + routes_[r].name}, {"time", nullptr}};
      if (meter_) {
        std::string reached, unknown;
        double first = kNotYet;
        for (std::size_t c = 0; c < meter_->criteria().size(); ++c) {
          const LossTimes& times = meter_->times(c);
          const double time = times.by(survey_->round)[r];
          if (!times.complete(r)) {
            unknown += fmt::format(
                "{}{} ({}{})", unknown.empty() ? "" : ", ", meter_->criteria()[c].name,
                std::isinf(times.known[r])
                    ? std::string("at no time")
                    : fmt::format("not after {} s", plainNumber(times.known[r], 4)),
                std::isinf(time)
                    ? std::string()
                    : fmt::format("; reached at the latest at {} s", plainNumber(times.up[r], 4)));
            continue;
          }
          if (std::isinf(time))
            continue;
          first = std::min(first, time);
          reached += fmt::format("{}{} at {} s", reached.empty() ? "" : ", ",
                                 meter_->criteria()[c].name, plainNumber(time, 4));
        }
        if (!unknown.empty())
          text += "; not known on the whole way: " + unknown;
        if (!reached.empty())
          text += fmt::format("; reached {}on the way: {}",
                              walking_.start.waits() ? "while waiting or " : "", reached);
        else
          text += unknown.empty() ? "; no criterion of tenability is reached on the way"
                                  : "; none of the others is reached on the way";
        json["known"] = unknown.empty();
        if (first < kNotYet)
          json["time"] = first;
      }
      json["sentence"] = text + ".";
      verdict.push_back(std::move(json));
    }
    report["verdict"] = std::move(verdict);
  }

  /// "starts at 30 s", and why then.
  std::string startWords(std::size_t r) const {
    const WalkStart& start = walking_.start;
    if (!start.waits())
      return fmt::format("starts at {} s", plainNumber(start.time));
    const std::string smoke = fmt::format("an extinction of {:g} 1/m where {} begins", start.smoke,
                                          start.heard ? "a walk" : "the walk");
    if (starts_[r] == kNotYet)
      return fmt::format("waits for {}", smoke);
    return fmt::format("starts at {} s, {} s after {},", plainNumber(starts_[r], 4),
                       plainNumber(start.delay), smoke);
  }

  template <class Seen>
  double shareOf(std::size_t route, Seen&& seen) const {
    double share = 0;
    for (std::size_t i = firstStations_[route]; i < firstStations_[route + 1]; ++i) {
      if (seen(i))
        share += stations_[i].share;
    }
    return std::min(share, 1.0);
  }

  void noteCoverage(const SurveyTime& at) {
    const std::size_t eyes = eyes_.size(), signs = survey_->signs.size();
    coverageTimes_.push_back(at.time);
    for (std::size_t r = 0; r < routes_.size(); ++r) {
      const auto anySign = [&](auto&& is) {
        return shareOf(r, [&](std::size_t i) {
          bool any = false;
          for (std::size_t s = 0; s < signs; ++s)
            any |= isFor(s, r) && is(at.sightings[s * eyes + i]);
          return any;
        });
      };
      coverage_.push_back(anySign([](const Sighting& one) { return one.visible; }));
      coverage_.push_back(anySign([](const Sighting& one) { return one.certainly; }));
      coverage_.push_back(anySign([](const Sighting& one) { return one.possibly; }));
      for (std::size_t s = 0; s < signs; ++s)
        coverage_.push_back(
            shareOf(r, [&](std::size_t i) { return at.sightings[s * eyes + i].visible; }));
    }
  }

  /// Shares of a route at a time from which any sign is seen, at least and at most, and each.
  std::span<const double> coverageOf(std::size_t time, std::size_t route) const {
    const std::size_t size = 3 + survey_->signs.size();
    return std::span(coverage_).subspan((time * routes_.size() + route) * size, size);
  }

  /// What walkers see who arrive between the last time and this one: optical depths are linear in
  /// between, as the smoke is; what is opaque is that of the last time, which is given anew
  /// whenever something opaque comes or goes.
  void noteWalk(const SurveyTime& at) {
    for (std::size_t i = 0; i < stations_.size(); ++i) {
      const double when = stations_[i].arrival;
      const bool now = when == at.time;
      if (!now && (last_.empty() || !(when > lastTime_ && when < at.time)))
        continue;
      walk_[i].clear();  // of the same time before something opaque came or went
      for (std::size_t s = 0; s < survey_->signs.size(); ++s) {
        const Sighting& after = at.sightings[s * eyes_.size() + i];
        if (now) {
          walk_[i].push_back(after);
          continue;
        }
        const Sighting& before = last_[s * eyes_.size() + i];
        const double share = (when - lastTime_) / (at.time - lastTime_);
        const auto mix = [&](double Sighting::* what) {
          return before.*what + share * (after.*what - before.*what);
        };
        walk_[i].push_back(
            judged(before, mix(&Sighting::depth), mix(&Sighting::low), mix(&Sighting::high)));
      }
    }
  }

  Json routeJson(std::size_t r) const {
    Json json = {{"name", routes_[r].name}, {"length", routes_[r].length()}};
    json["coverage"] = Json::array();
    for (std::size_t t = 0; t < coverageTimes_.size(); ++t) {
      const auto shares = coverageOf(t, r);
      Json bySign = Json::object();
      for (std::size_t s = 0; s < survey_->signs.size(); ++s) {
        if (isFor(s, r))
          bySign[survey_->signs[s].sign.name] = shares[3 + s];
      }
      json["coverage"].push_back({{"time", coverageTimes_[t]},
                                  {"any", shares[0]},
                                  {"any_low", shares[1]},
                                  {"any_high", shares[2]},
                                  {"signs", std::move(bySign)}});
    }
    Json walk = Json::array();
    double seen = 0, known = 0;
    for (std::size_t i = firstStations_[r]; i < firstStations_[r + 1]; ++i) {
      Json record = {{"time", jsonNumber(stations_[i].arrival)},
                     {"along", stations_[i].along},
                     {"position", {eyes_[i][0], eyes_[i][1], eyes_[i][2]}}};
      if (walk_[i].empty()) {
        record["seen"] = nullptr;  // the smoke's times end before
      } else {
        record["seen"] = Json::array();
        Json unsure = Json::array();
        for (std::size_t s = 0; s < walk_[i].size(); ++s) {
          const Sighting& sighting = walk_[i][s];
          if (!isAhead(s, i))
            continue;
          if (sighting.visible)
            record["seen"].push_back(survey_->signs[s].sign.name);
          if (sighting.seen() == Seen::kCannotTell)
            unsure.push_back(survey_->signs[s].sign.name);
        }
        if (!unsure.empty())
          record["cannot_tell"] = std::move(unsure);
        known += stations_[i].share;
        seen += record["seen"].empty() ? 0 : stations_[i].share;
      }
      walk.push_back(std::move(record));
    }
    json["walk"] = std::move(walk);
    json["arrival"] = jsonNumber(stations_[firstStations_[r + 1] - 1].arrival);
    json["start"] = jsonNumber(starts_[r]);
    json["arrival_known"] = !unsure_[r] && !json["arrival"].is_null();
    if (meter_) {
      json["exposure"] = Json::array();
      for (std::size_t c = 0; c < meter_->criteria().size(); ++c) {
        const LossTimes& times = meter_->times(c);
        const bool known = times.complete(r);
        json["exposure"].push_back(
            {{"name", meter_->criteria()[c].name},
             {meter_->criteria()[c].isDose() ? "dose" : "worst_value",
              meter_->unknown(c, r) ? Json() : jsonNumber(meter_->worst(c)[r])},
             {"time", known ? jsonNumber(times.by(survey_->round)[r]) : Json()},
             {"known", knownJson(times.known[r])},
             {"time_interpolated", known ? jsonNumber(times.none[r]) : Json()}});
        if (!known && !std::isinf(times.up[r]))
          json["exposure"].back()["at_the_latest"] = times.up[r];
        if (const LossTimes* latest = meter_->latest(c))
          json["exposure"].back()["time_latest"] = jsonNumber(latest->answer(r, survey_->round));
        if (const auto allowed = meter_->worstAllowed(c); !allowed.empty()) {
          json["exposure"]
              .back()[meter_->criteria()[c].isDose() ? "dose_at_most" : "worst_value_at_most"] =
              meter_->unknown(c, r) ? Json() : jsonNumber(allowed[r]);
        }
      }
    }
    json["walk_share_known"] = std::min(known, 1.0);
    json["walk_share_with_a_sign"] = std::min(seen, 1.0);
    return json;
  }

  std::string routePlot(std::size_t r) const {
    PlotLine any{"any sign", {}};
    std::vector<PlotLine> lines;
    for (std::size_t t = 0; t < coverageTimes_.size(); ++t) any.y.push_back(coverageOf(t, r)[0]);
    for (std::size_t s = 0; s < survey_->signs.size(); ++s) {
      if (!isFor(s, r))
        continue;
      lines.push_back({survey_->signs[s].sign.name, {}});
      for (std::size_t t = 0; t < coverageTimes_.size(); ++t)
        lines.back().y.push_back(coverageOf(t, r)[3 + s]);
    }
    if (survey_->times.size() < 2)
      return "";
    any.dashed = true;
    lines.insert(lines.begin(), any);
    return linePlot(
        fmt::format("Route {}: share of its length from which a sign is visible", routes_[r].name),
        "time [s]", "share", survey_->times, lines);
  }

  std::string walkTable(const Json& routes) const {
    std::vector<HtmlRow> rows;
    for (const Json& route : routes) {
      const double known = route["walk_share_known"].get<double>();
      const double length = route["length"].get<double>();
      rows.push_back(
          {htmlOf(route["name"]), fmt::format("{:.1f}", length), htmlOf(route["arrival"], "{:.0f}"),
           htmlOf(100 * route["walk_share_with_a_sign"].get<double>(), "{:.0f} %") +
               (known < 0.999 ? fmt::format(" (smoke is known for {:.0f} % of it)", 100 * known)
                              : "")});
    }
    return fmt::format("<p>A person who {} and walks at {:g} m/s in clear air ({}):</p>\n",
                       walking_.start.waits() ? std::string("waits for smoke") : startWords(0),
                       walking_.speed, speedSource()) +
           htmlTable({"route", "length [m]", "arrives [s]", "share of the way with a sign in view"},
                     rows);
  }

  Status drawRoutePlan() const {
    PlanPicture picture;
    picture.title = fmt::format("Routes at z = {} m", plainNumber(eyes_[0][2]));
    picture.marks = emptyMarks(plan_);
    picture.north = survey_->north;
    for (std::size_t i = 0; i < plan_.size(); ++i) {
      if (plan_.walkable(i))
        picture.marks[i] = PlanMark::kFloor;
    }
    picture.words = {{PlanMark::kUnknown, kNoData}, {PlanMark::kSolid, kSolidWords}};
    return writeImage(survey_->folder / "routes.png",
                      drawPlan(plan_, picture, survey_->signs, routes_));
  }

  static constexpr std::size_t kPlots = 200;  // as many as somebody looks through

  const Survey* survey_ = nullptr;
  std::vector<Route> routes_;
  Walk walking_;
  std::vector<double> starts_;                   // of each walker [s]
  std::vector<std::vector<TrackPoint>> tracks_;  // of each walker whom smoke slows down
  std::vector<bool> unsure_;                     // walkers in smoke that is not known
  std::vector<double> extinction_;               // at the stations, at the last time
  double smokeBefore_ = 0;                       // the last stored time [s]
  std::vector<double> highBefore_, lowBefore_;   // the same then
  double smokeTime_ = 0;
  std::optional<ExposureMeter> meter_;
  std::vector<Station> stations_;           // of one route after the other
  std::vector<std::size_t> firstStations_;  // of each route, and the end
  std::vector<Vec3> eyes_;
  FloorPlan plan_;
  std::vector<double> coverageTimes_;
  std::vector<double> coverage_;             // of each time and route: coverageOf()
  std::vector<std::vector<Sighting>> walk_;  // of each station, when a walker is there
  std::vector<Sighting> last_;
  double lastTime_ = 0;
};

}  // namespace

Result<WalkStart> walkStart(std::string_view text) {
  const auto wrong = [&] {
    return fail(ErrorCode::kInvalidArgument,
                "start '{}': expected seconds, smoke:K or smoke:K,DELAY (an extinction K > 0 [1/m] "
                "that is seen where the walk begins, and seconds >= 0 until people go), or heard:K "
                "or heard:K,DELAY (seen where any walk begins)",
                text);
  };
  WalkStart start;
  const std::size_t colon = text.find(':');
  const std::string_view how = text.substr(0, colon);
  if (colon == text.npos) {
    if (!readNumber(text, start.time) || !std::isfinite(start.time))
      return wrong();
    return start;
  }
  if (how != "smoke" && how != "heard")
    return wrong();
  start.heard = how == "heard";
  const std::string_view rest = text.substr(colon + 1);
  const std::size_t comma = rest.find(',');
  if (!readNumber(rest.substr(0, comma), start.smoke) ||
      (comma != rest.npos && !readNumber(rest.substr(comma + 1), start.delay)) ||
      !(start.smoke > 0) || !(start.delay >= 0) || !std::isfinite(start.smoke + start.delay))
    return wrong();
  return start;
}

std::unique_ptr<Watch> routeWatch(std::vector<Route> routes, const Walk& walk) {
  return std::make_unique<RouteWatch>(std::move(routes), walk);
}

}  // namespace volute
