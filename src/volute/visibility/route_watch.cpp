// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>
#include <cmath>

#include "volute/io/image_file.hpp"
#include "volute/report/line_plot.hpp"
#include "volute/report/page.hpp"
#include "volute/visibility/plan_picture.hpp"
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

class RouteWatch final : public Watch {
 public:
  RouteWatch(std::vector<Route> routes, double speed, double start)
      : routes_(std::move(routes)), speed_(speed), start_(start) {}

  Status begin(const Survey& survey, const SightInstant& first, Progress& progress) override {
    survey_ = &survey;
    for (std::size_t r = 0; r < routes_.size(); ++r) addStations(r);
    std::vector<Place> places(eyes_.size());
    first.places(eyes_, places);
    const auto lost =
        std::ranges::count_if(places, [](Place place) { return place != Place::kGas; });
    if (lost == static_cast<std::ptrdiff_t>(eyes_.size())) {
      return fail(ErrorCode::kInvalidArgument,
                  "--route: no point of the routes is where the case has smoke, {:g} .. {:g}, {:g} "
                  ".. {:g}, {:g} .. {:g} m; check the coordinates and --height",
                  survey.bounds.min[0], survey.bounds.max[0], survey.bounds.min[1],
                  survey.bounds.max[1], survey.bounds.min[2], survey.bounds.max[2]);
    }
    if (lost > 0)
      progress.remark(fmt::format(
          "{} of {} points of the routes are inside something solid or where the case has no smoke",
          lost, eyes_.size()));
    // At the routes' own height, to draw them on.
    auto plan = floorPlan(first, survey.bounds, eyes_[0][2], survey.step);
    if (plan)
      plan_ = std::move(*plan);
    walk_.resize(stations_.size());
    coverage_ = Json::array();
    return {};
  }

  std::vector<Vec3> eyes(double) const override { return eyes_; }

  Status take(const SurveyTime& at) override {
    noteCoverage(at);
    noteWalk(at);
    last_.assign(at.sightings.begin(), at.sightings.end());
    lastTime_ = at.time;
    return {};
  }

  Result<std::string> finish(Json& report) override {
    report["eyes"] = {{"kind", "routes"}, {"step", survey_->step}, {"count", eyes_.size()}};
    report["walk"] = {{"speed", speed_}, {"start", start_}};
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
      page += routePlot(r);
    }
    return page + walkTable(report["routes"]);
  }

 private:
  void addStations(std::size_t r) {
    const auto along = stationsOf(routes_[r], survey_->step);
    const double length = routes_[r].length();
    for (std::size_t i = 0; i < along.size(); ++i) {
      const double before = i > 0 ? along[i - 1] : along[i];
      const double after = i + 1 < along.size() ? along[i + 1] : along[i];
      stations_.push_back(
          {r, along[i], 0.5 * (after - before) / length, start_ + along[i] / speed_});
      eyes_.push_back(routes_[r].at(along[i]));
    }
  }

  template <class Seen>
  double shareOf(std::size_t route, Seen&& seen) const {
    double share = 0;
    for (std::size_t i = 0; i < stations_.size(); ++i) {
      if (stations_[i].route == route && seen(i))
        share += stations_[i].share;
    }
    return std::min(share, 1.0);
  }

  void noteCoverage(const SurveyTime& at) {
    const std::size_t eyes = eyes_.size(), signs = survey_->signs.size();
    Json routes = Json::array();
    for (std::size_t r = 0; r < routes_.size(); ++r) {
      const auto anySign = [&](bool Sighting::* what) {
        return shareOf(r, [&](std::size_t i) {
          bool any = false;
          for (std::size_t s = 0; s < signs; ++s) any |= at.sightings[s * eyes + i].*what;
          return any;
        });
      };
      Json bySign = Json::object();
      for (std::size_t s = 0; s < signs; ++s) {
        bySign[survey_->signs[s].sign.name] =
            shareOf(r, [&](std::size_t i) { return at.sightings[s * eyes + i].visible; });
      }
      routes.push_back({{"time", at.time},
                        {"any", anySign(&Sighting::visible)},
                        {"any_low", anySign(&Sighting::certainly)},
                        {"any_high", anySign(&Sighting::possibly)},
                        {"signs", bySign}});
    }
    coverage_.push_back(std::move(routes));
  }

  /// What walkers see who arrive between the last time and this one: optical depths are linear in
  /// between, as the smoke is; what is opaque is that of the last time.
  void noteWalk(const SurveyTime& at) {
    for (std::size_t i = 0; i < stations_.size(); ++i) {
      const double when = stations_[i].arrival;
      const bool now = when == at.time;
      if (!now && (last_.empty() || !(when > lastTime_ && when < at.time)))
        continue;
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
        walk_[i].push_back(judged(survey_->signs[s].sign, before, mix(&Sighting::depth),
                                  mix(&Sighting::low), mix(&Sighting::high)));
      }
    }
  }

  Json routeJson(std::size_t r) const {
    Json json = {{"name", routes_[r].name}, {"length", routes_[r].length()}};
    json["coverage"] = Json::array();
    for (const Json& record : coverage_) json["coverage"].push_back(record[r]);
    Json walk = Json::array();
    double seen = 0, known = 0;
    for (std::size_t i = 0; i < stations_.size(); ++i) {
      if (stations_[i].route != r)
        continue;
      Json record = {{"time", stations_[i].arrival},
                     {"along", stations_[i].along},
                     {"position", {eyes_[i][0], eyes_[i][1], eyes_[i][2]}}};
      if (walk_[i].empty()) {
        record["seen"] = nullptr;  // the smoke's times end before
      } else {
        record["seen"] = Json::array();
        for (std::size_t s = 0; s < walk_[i].size(); ++s) {
          if (walk_[i][s].visible)
            record["seen"].push_back(survey_->signs[s].sign.name);
        }
        known += stations_[i].share;
        seen += record["seen"].empty() ? 0 : stations_[i].share;
      }
      walk.push_back(std::move(record));
    }
    json["walk"] = std::move(walk);
    json["walk_share_known"] = std::min(known, 1.0);
    json["walk_share_with_a_sign"] = std::min(seen, 1.0);
    return json;
  }

  std::string routePlot(std::size_t r) const {
    PlotLine any{"any sign", {}};
    std::vector<PlotLine> lines;
    for (const SightTarget& sign : survey_->signs) lines.push_back({sign.sign.name, {}});
    for (const Json& record : coverage_) {
      any.y.push_back(record[r]["any"].get<double>());
      for (PlotLine& line : lines) line.y.push_back(record[r]["signs"][line.name].get<double>());
    }
    if (survey_->times.size() < 2)
      return "";
    any.dashed = true;
    lines.insert(lines.begin(), any);
    return linePlot(
        fmt::format("Route {}: share of its length from which a sign is seen", routes_[r].name),
        "time [s]", "share", survey_->times, lines);
  }

  std::string walkTable(const Json& routes) const {
    std::vector<HtmlRow> rows;
    for (const Json& route : routes) {
      const double known = route["walk_share_known"].get<double>();
      const double length = route["length"].get<double>();
      rows.push_back(
          {htmlOf(route["name"]), fmt::format("{:.1f}", length),
           fmt::format("{:.0f}", start_ + length / speed_),
           htmlOf(100 * route["walk_share_with_a_sign"].get<double>(), "{:.0f} %") +
               (known < 0.999 ? fmt::format(" (smoke is known for {:.0f} % of it)", 100 * known)
                              : "")});
    }
    return fmt::format("<p>Someone who sets out at {:g} s and walks at {:g} m/s:</p>\n", start_,
                       speed_) +
           htmlTable({"route", "length [m]", "arrives [s]", "share of the way with a sign in view"},
                     rows);
  }

  Status drawRoutePlan() const {
    PlanPicture picture;
    picture.title = fmt::format("Routes at z = {:g} m", eyes_[0][2]);
    picture.marks.assign(plan_.size(), PlanMark::kSolid);
    for (std::size_t i = 0; i < plan_.size(); ++i) {
      if (plan_.walkable(i))
        picture.marks[i] = PlanMark::kFloor;
    }
    picture.words = {{PlanMark::kSolid, "solid, or no data"}};
    return writeImage(survey_->folder / "routes.png",
                      drawPlan(plan_, picture, survey_->signs, routes_));
  }

  const Survey* survey_ = nullptr;
  std::vector<Route> routes_;
  double speed_, start_;
  std::vector<Station> stations_;
  std::vector<Vec3> eyes_;
  FloorPlan plan_;
  Json coverage_;                            // of each time, a list of routes
  std::vector<std::vector<Sighting>> walk_;  // of each station, when a walker is there
  std::vector<Sighting> last_;
  double lastTime_ = 0;
};

}  // namespace

std::unique_ptr<Watch> routeWatch(std::vector<Route> routes, double speed, double start) {
  return std::make_unique<RouteWatch>(std::move(routes), speed, start);
}

}  // namespace volute
