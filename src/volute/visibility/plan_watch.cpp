// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>
#include <cmath>
#include <limits>

#include "volute/base/parallel.hpp"
#include "volute/io/image_file.hpp"
#include "volute/report/line_plot.hpp"
#include "volute/report/page.hpp"
#include "volute/visibility/plan_picture.hpp"
#include "volute/visibility/plan_vti.hpp"
#include "volute/visibility/watch.hpp"

namespace volute {
namespace {

constexpr float kNoFloat = std::numeric_limits<float>::quiet_NaN();
/// Where the colours of visibility end [m]: what FDS writes at most.
constexpr double kFar = 30;

class PlanWatch final : public Watch {
 public:
  Status begin(const Survey& survey, const SightInstant& first, Progress& progress) override {
    survey_ = &survey;
    VOLUTE_ASSIGN(plan_, floorPlan(first, survey.bounds, survey.height, survey.step));
    shapes_ = first.shapes(plan_.origin[2]);
    for (std::size_t i = 0; i < plan_.size(); ++i) {
      if (plan_.walkable(i)) {
        places_.push_back(i);
        eyes_.push_back(plan_.at(i));
      }
    }
    if (eyes_.empty()) {
      return fail(
          ErrorCode::kInvalidArgument,
          "--height: nobody can look from z = {:g} m: the case knows smoke between z = {:g} "
          "and {:g} m; expected a height where there is gas",
          survey.height, survey.bounds.min[2], survey.bounds.max[2]);
    }
    if (survey.maps && survey.signs.size() * survey.times.size() > 2000) {
      progress.remark(fmt::format(
          "{} maps are written; --maps aset leaves them out, --frames takes fewer times",
          survey.signs.size() * survey.times.size()));
    }
    losses_.assign(survey.sets.size(), LossTimes(eyes_.size()));
    hidden_.assign(survey.sets.size(), std::vector<bool>(eyes_.size(), true));
    local_.assign(eyes_.size(), std::numeric_limits<double>::infinity());
    std::error_code error;
    std::filesystem::create_directory(survey.folder / "maps", error);
    series_.resize(survey.signs.size());
    return {};
  }

  std::vector<Vec3> eyes(double) const override { return eyes_; }

  Status take(const SurveyTime& at) override {
    for (std::size_t set = 0; set < survey_->sets.size(); ++set)
      updateLoss(losses_[set], at.time, survey_->sets[set].members, at.sightings);
    if (at.index == 0)
      noteHidden(at);
    if (survey_->extinctionLimit > 0)
      updateLocal(at);
    if (survey_->maps) {
      for (std::size_t s = 0; s < series_.size(); ++s)
        series_[s].emplace_back(at.time, fmt::format("{}_{:04d}.vti", mapName(s), at.index));
    }
    ++index_;
    return {};
  }

  Status draw(const SurveyTime& at) const override {
    return survey_->maps ? writeMaps(at) : Status();
  }

  Result<std::string> finish(Json& report) override {
    report["eyes"] = {{"kind", "plan"},          {"height", plan_.origin[2]},
                      {"step", plan_.step},      {"origin", {plan_.origin[0], plan_.origin[1]}},
                      {"nx", plan_.nx},          {"ny", plan_.ny},
                      {"walkable", eyes_.size()}};
    report["plan"] = walkable();
    for (std::size_t s = 0; s < series_.size(); ++s) {
      if (!series_[s].empty())
        VOLUTE_TRY(writePvd(survey_->folder / "maps" / (mapName(s) + ".pvd"), series_[s]));
    }
    std::string page;
    report["aset"] = Json::array();
    std::vector<PlanArray> arrays;
    for (std::size_t set = 0; set < survey_->sets.size(); ++set) {
      report["aset"].push_back(asetJson(set));
      addArrays(set, arrays);
      VOLUTE_TRY(writeAset(set));
      VOLUTE_ASSIGN(const auto figure,
                    htmlFigure(survey_->folder / asetName(set),
                             fmt::format("When {} seen any more.", setWords(set))));
      page += figure;
    }
    if (survey_->extinctionLimit > 0) {
      report["aset_local"] = {{"extinction", survey_->extinctionLimit}, {"rows", rowsOf(local_)}};
      arrays.push_back({"aset_local", overPlan(local_)});
      VOLUTE_TRY(writeLocal());
      VOLUTE_ASSIGN(const auto figure,
                    htmlFigure(survey_->folder / "aset_local.png",
                             "When the smoke where one stands reaches the limit."));
      page += figure;
    }
    VOLUTE_TRY(writePlanVti(survey_->folder / "aset.vti", plan_, arrays));
    VOLUTE_ASSIGN(const auto shown, shownMaps());
    return "<h2>Available safe egress time by visibility</h2>\n" + page + shown;
  }

 private:
  std::string mapName(std::size_t sign) const {
    return fmt::format("{}_{}", sign + 1, Survey::fileName(survey_->signs[sign].sign.name));
  }

  std::string asetName(std::size_t set) const {
    return set == 0 ? "aset.png"
                    : fmt::format("aset_{}_{}.png", set, Survey::fileName(survey_->sets[set].name));
  }

  std::string setWords(std::size_t set) const {
    const auto& members = survey_->sets[set].members;
    return members.size() == 1
               ? "sign " + survey_->signs[members[0]].sign.name + " is not"
               : (set == 0 ? "no sign is" : "no sign of " + survey_->sets[set].name + " is");
  }

  /// Points from which no sign of a set is in sight before there is smoke.
  void noteHidden(const SurveyTime& at) {
    for (std::size_t set = 0; set < survey_->sets.size(); ++set) {
      for (const std::size_t s : survey_->sets[set].members) {
        for (std::size_t i = 0; i < eyes_.size(); ++i) {
          if (inSight(at.sightings[s * eyes_.size() + i]))
            hidden_[set][i] = false;
        }
      }
    }
  }

  static bool inSight(const Sighting& sighting) {
    return !sighting.blocked && sighting.covered && sighting.visibility > 0;
  }

  void updateLocal(const SurveyTime& at) {
    for (std::size_t i = 0; i < eyes_.size(); ++i) {
      if (at.extinction[i] >= survey_->extinctionLimit && at.time < local_[i])
        local_[i] = at.time;
    }
  }

  /// Values of eyes at the plan's points; NaN elsewhere.
  std::vector<float> overPlan(std::span<const double> values) const {
    std::vector<float> out(plan_.size(), kNoFloat);
    for (std::size_t i = 0; i < places_.size(); ++i)
      out[places_[i]] = static_cast<float>(values[i]);
    return out;
  }

  template <class Value>
  std::vector<float> mapOf(const SurveyTime& at, std::size_t sign, Value&& value) const {
    std::vector<float> out(plan_.size(), kNoFloat);
    for (std::size_t i = 0; i < places_.size(); ++i)
      out[places_[i]] = static_cast<float>(value(at.sightings[sign * eyes_.size() + i]));
    return out;
  }

  PlanPicture visibilityMap(const SurveyTime& at, std::size_t s) const {
    const SafetySign& sign = survey_->signs[s].sign;
    PlanPicture picture;
    picture.title = fmt::format("{} at {:.4g} s, seen from z = {:g} m", sign.name, at.time,
                                plan_.origin[2]);
    picture.subtitle = fmt::format("S = C / mean K, {} C = {:.4g}, angle {}", sign.law.name,
                                   sign.law.c, nameOf(sign.angle));
    picture.barLabel = "visibility S [m]";
    picture.high = kFar;
    picture.highIsMore = true;
    picture.shapes = at.instant.shapes(plan_.origin[2]);
    picture.underlay = survey_->underlay;
    picture.values.assign(plan_.size(), 0);
    picture.marks.assign(plan_.size(), PlanMark::kSolid);
    for (std::size_t i = 0; i < places_.size(); ++i) {
      const Sighting& sighting = at.sightings[s * eyes_.size() + i];
      picture.values[places_[i]] = sighting.visibility;
      picture.marks[places_[i]] = sighting.visible    ? PlanMark::kValue
                                  : inSight(sighting) ? PlanMark::kLost
                                                      : PlanMark::kHidden;
    }
    picture.words = {{PlanMark::kLost, "lost in the smoke"},
                     {PlanMark::kHidden, "sign not in sight: wall, or seen from behind"},
                     {PlanMark::kSolid, "nobody stands there: solid, or no data"}};
    return picture;
  }

  Status writeMaps(const SurveyTime& at) const {
    const auto folder = survey_->folder / "maps";
    std::vector<Status> done(survey_->signs.size());
    parallelFor(survey_->signs.size(), [&](std::size_t s) {
      const std::string name = fmt::format("{}_{:04d}", mapName(s), at.index);
      const auto of = [&](const char* what, auto&& value) {
        return PlanArray{what, mapOf(at, s, value)};
      };
      done[s] =
          writePlanVti(folder / (name + ".vti"), plan_,
                       {of("optical_depth", [](const Sighting& x) { return x.depth; }),
                        of("optical_depth_low", [](const Sighting& x) { return x.low; }),
                        of("optical_depth_high", [](const Sighting& x) { return x.high; }),
                        of("mean_extinction", [](const Sighting& x) { return x.meanExtinction; }),
                        of("visibility", [](const Sighting& x) { return x.visibility; }),
                        of("blocked", [](const Sighting& x) { return x.blocked ? 1 : 0; }),
                        of("visible", [](const Sighting& x) { return x.visible ? 1 : 0; })});
      if (done[s]) {
        const std::span one(&survey_->signs[s], 1);
        done[s] =
            writeImage(folder / (name + ".png"), drawPlan(plan_, visibilityMap(at, s), one));
      }
    });
    for (Status& status : done) VOLUTE_TRY(std::move(status));
    return {};
  }

  Json rowsOf(std::span<const double> values) const {
    std::vector<double> all(plan_.size(), std::numeric_limits<double>::infinity());
    for (std::size_t i = 0; i < places_.size(); ++i) all[places_[i]] = values[i];
    Json rows = Json::array();
    for (int y = 0; y < plan_.ny; ++y) {
      Json row = Json::array();
      for (int x = 0; x < plan_.nx; ++x)
        row.push_back(jsonNumber(all[static_cast<std::size_t>(y) * plan_.nx + x]));
      rows.push_back(std::move(row));
    }
    return rows;
  }

  /// Rows of 1 (one can stand there) and 0, from the smallest y.
  Json walkable() const {
    Json rows = Json::array();
    for (int y = 0; y < plan_.ny; ++y) {
      std::string row;
      for (int x = 0; x < plan_.nx; ++x)
        row += plan_.walkable(static_cast<std::size_t>(y) * plan_.nx + x) ? '1' : '0';
      rows.push_back(row);
    }
    return rows;
  }

  Json asetJson(std::size_t set) const {
    const LossTimes& loss = losses_[set];
    Json names = Json::array();
    for (const std::size_t s : survey_->sets[set].members)
      names.push_back(survey_->signs[s].sign.name);
    const auto kept = std::ranges::count_if(loss.time, [](double t) { return std::isinf(t); });
    const auto out = std::ranges::count(hidden_[set], true);
    return {{"set", survey_->sets[set].name},    {"signs", names},
            {"kept_to_the_end", kept},           {"never_in_sight", out},
            {"rows", rowsOf(loss.time)},         {"rows_earliest", rowsOf(loss.earliest)},
            {"rows_latest", rowsOf(loss.latest)}};
  }

  void addArrays(std::size_t set, std::vector<PlanArray>& arrays) const {
    const LossTimes& loss = losses_[set];
    const std::string name =
        set == 0 ? "" : fmt::format("_{}_{}", set, Survey::fileName(survey_->sets[set].name));
    arrays.push_back({"aset" + name, overPlan(loss.time)});
    arrays.push_back({"aset_earliest" + name, overPlan(loss.earliest)});
    arrays.push_back({"aset_latest" + name, overPlan(loss.latest)});
  }

  PlanPicture lossPicture(std::span<const double> times) const {
    PlanPicture picture;
    picture.barLabel = "time [s]";
    picture.stored = true;
    picture.shapes = shapes_;
    picture.underlay = survey_->underlay;
    picture.low = survey_->times.front();
    picture.high = std::max(survey_->times.back(), picture.low + 1e-9);
    picture.values.assign(plan_.size(), 0);
    picture.marks.assign(plan_.size(), PlanMark::kSolid);
    for (std::size_t i = 0; i < places_.size(); ++i) {
      picture.values[places_[i]] = times[i];
      picture.marks[places_[i]] = std::isinf(times[i]) ? PlanMark::kKept : PlanMark::kValue;
    }
    return picture;
  }

  Status writeAset(std::size_t set) const {
    PlanPicture picture = lossPicture(losses_[set].time);
    for (std::size_t i = 0; i < places_.size(); ++i) {
      if (hidden_[set][i])
        picture.marks[places_[i]] = PlanMark::kHidden;
    }
    picture.title =
        fmt::format("First time at which {} seen, from z = {:g} m", setWords(set), plan_.origin[2]);
    picture.subtitle = lawsOf(set);
    picture.words = {{PlanMark::kKept,
                      fmt::format("never lost: still seen at {:g} s, the last time",
                                  survey_->times.back())},
                     {PlanMark::kHidden, "no sign in sight, smoke or not"},
                     {PlanMark::kSolid, "nobody stands there: solid, or no data"}};
    std::vector<SightTarget> signs;
    for (const std::size_t s : survey_->sets[set].members) signs.push_back(survey_->signs[s]);
    return writePlan(survey_->folder / asetName(set), plan_, picture, signs);
  }

  std::string lawsOf(std::size_t set) const {
    std::vector<std::string> laws;
    for (const std::size_t s : survey_->sets[set].members) {
      const VisibilityLaw& law = survey_->signs[s].sign.law;
      const auto text = fmt::format("{} C = {:.4g}", law.name, law.c);
      if (std::ranges::find(laws, text) == laws.end())
        laws.push_back(text);
    }
    return fmt::format("optical depth > C; {}", fmt::join(laws, ", "));
  }

  Status writeLocal() const {
    PlanPicture picture = lossPicture(local_);
    picture.title = fmt::format("First time with K >= {:g} 1/m at z = {:g} m",
                                survey_->extinctionLimit, plan_.origin[2]);
    picture.subtitle = "smoke where one stands, signs aside";
    picture.words = {
        {PlanMark::kKept, fmt::format("below it at {:g} s, the last time", survey_->times.back())},
        {PlanMark::kSolid, "nobody stands there: solid, or no data"}};
    return writePlan(survey_->folder / "aset_local.png", plan_, picture, survey_->signs);
  }

  /// Maps at a few times in the page.
  Result<std::string> shownMaps() const {
    if (!survey_->maps || index_ == 0)
      return std::string();
    std::string page = "<h2>Visibility of each sign</h2>\n";
    std::vector<int> shown{0, index_ / 3, 2 * index_ / 3, index_ - 1};
    shown.erase(std::ranges::unique(shown).begin(), shown.end());
    constexpr std::size_t kMost = 6;
    for (std::size_t s = 0; s < std::min(kMost, survey_->signs.size()); ++s) {
      for (const int i : shown) {
        const auto file = survey_->folder / "maps" / fmt::format("{}_{:04d}.png", mapName(s), i);
        VOLUTE_ASSIGN(const auto figure,
                      htmlFigure(file, fmt::format("{} at {:g} s", survey_->signs[s].sign.name,
                                                 survey_->times[static_cast<std::size_t>(i)])));
        page += figure;
      }
    }
    return page;
  }

  const Survey* survey_ = nullptr;
  FloorPlan plan_;
  std::vector<std::size_t> places_;  // of each eye in the plan
  std::vector<Vec3> eyes_;
  std::vector<LossTimes> losses_;          // of each set
  std::vector<std::vector<bool>> hidden_;  // the same
  std::vector<double> local_;
  std::vector<PlanShape> shapes_;  // at the first time
  std::vector<std::vector<std::pair<double, std::string>>> series_;  // of each sign
  int index_ = 0;
};

}  // namespace

std::unique_ptr<Watch> planWatch() {
  return std::make_unique<PlanWatch>();
}

}  // namespace volute
