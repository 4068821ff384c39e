// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/watch.hpp"

#include "volute/report/line_plot.hpp"

namespace volute {
namespace {

/// Points of a file, or people who walk. Gives sight.csv and figures, no page.
class PointWatch : public Watch {
 public:
  explicit PointWatch(std::vector<Vec3> points) : points_(std::move(points)) {}

  Status begin(const Survey& survey, const SightInstant& first, Progress& progress) override {
    survey_ = &survey;
    std::vector<Place> places(points_.size());
    first.places(points_, places);
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (places[i] != Place::kGas) {
        progress.remark(fmt::format(
            "eye {} at {:g}, {:g}, {:g} m is {}", i + 1, points_[i][0], points_[i][1],
            points_[i][2],
            places[i] == Place::kSolid ? "inside something solid" : "where the case has no smoke"));
      }
    }
    return {};
  }

  std::vector<Vec3> eyes(double) const override { return points_; }

  Status take(const SurveyTime&) override { return {}; }

  Result<std::string> finish(Json& report) override {
    report["eyes"] = {{"kind", "points"}, {"count", points_.size()}};
    return std::string();
  }

  bool hasPage() const override { return false; }

 private:
  const Survey* survey_ = nullptr;
  std::vector<Vec3> points_;
};

class TrajectoryWatch final : public Watch {
 public:
  explicit TrajectoryWatch(Trajectories people) : people_(std::move(people)) {}

  Status begin(const Survey& survey, const SightInstant&, Progress& progress) override {
    survey_ = &survey;
    if (people_.end() < survey.times.front() || people_.begin() > survey.times.back()) {
      progress.remark(fmt::format(
          "people walk from {:g} to {:g} s, the smoke is there from {:g} to {:g} s: nobody looks",
          people_.begin(), people_.end(), survey.times.front(), survey.times.back()));
    }
    return {};
  }

  std::vector<Vec3> eyes(double time) const override {
    std::vector<Vec3> eyes;
    for (const auto& person : people_.at(time)) eyes.push_back(person.eye);
    return eyes;
  }

  Status take(const SurveyTime& at) override {
    const auto people = people_.at(at.time);
    Json record = {{"time", at.time}, {"people", people.size()}, {"see_a_sign", 0}};
    Json ids = Json::array();
    for (std::size_t i = 0; i < people.size(); ++i) {
      bool any = false;
      for (std::size_t s = 0; s < survey_->signs.size(); ++s)
        any |= at.sightings[s * people.size() + i].visible;
      if (any)
        record["see_a_sign"] = record["see_a_sign"].get<int>() + 1;
      ids.push_back(people[i].id);
    }
    record["ids"] = std::move(ids);
    records_.push_back(std::move(record));
    return {};
  }

  Result<std::string> finish(Json& report) override {
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
    if (times.size() < 2)
      return std::string();
    return linePlot("People on their way, and those who see a sign", "time [s]", "people", times,
                    {there, seeing});
  }

 private:
  const Survey* survey_ = nullptr;
  Trajectories people_;
  Json records_ = Json::array();
};

}  // namespace

std::string Survey::fileName(std::string_view name) {
  std::string file;
  for (const char c : name) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       c == '-' || c == '_';
    file += plain ? c : '_';
  }
  return file;
}

std::unique_ptr<Watch> pointWatch(std::vector<Vec3> points) {
  return std::make_unique<PointWatch>(std::move(points));
}

std::unique_ptr<Watch> trajectoryWatch(Trajectories people) {
  return std::make_unique<TrajectoryWatch>(std::move(people));
}

}  // namespace volute
