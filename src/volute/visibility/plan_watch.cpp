// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "volute/base/parallel.hpp"
#include "volute/base/plain_number.hpp"
#include "volute/io/image_file.hpp"
#include "volute/report/line_plot.hpp"
#include "volute/report/page.hpp"
#include "volute/visibility/plan_areas.hpp"
#include "volute/visibility/plan_picture.hpp"
#include "volute/visibility/plan_tenability.hpp"
#include "volute/visibility/plan_use.hpp"
#include "volute/visibility/plan_values.hpp"
#include "volute/visibility/plan_vti.hpp"
#include "volute/visibility/sensitivity.hpp"
#include "volute/visibility/smoke_column.hpp"
#include "volute/visibility/verdict.hpp"
#include "volute/visibility/watch.hpp"

namespace volute {
namespace {

constexpr float kNoFloat = std::numeric_limits<float>::quiet_NaN();
constexpr std::uint64_t kPlace = 160;  ///< [bytes] of a point of the plan itself
/// Where the colours of visibility end [m]: what FDS writes at most.
constexpr double kFar = 30;

/// Where it burns is in the plan, on solids or not.
Status checkFires(const Survey& survey, const FloorPlan& plan) {
  for (const Vec3& fire : survey.fires) {
    bool held = false;
    for (std::size_t i = 0; i < plan.size() && !held; ++i)
      held = (plan.at(i) - fire).head<2>().norm() <= fire.z();
    if (held)
      continue;
    return failFor("fire_at", ErrorCode::kInvalidArgument,
                   "no point of the plan is within {} m of {}, {} m; the plan reaches from "
                   "{}, {} to {}, {} m, with points {:g} m apart",
                   plainNumber(fire.z()), plainNumber(fire.x()), plainNumber(fire.y()),
                   plainNumber(survey.bounds.min.x()), plainNumber(survey.bounds.min.y()),
                   plainNumber(survey.bounds.max.x()), plainNumber(survey.bounds.max.y()),
                   survey.step);
  }
  return {};
}

class PlanWatch final : public Watch {
 public:
  Status begin(const Survey& survey, const SightSnapshot& first, Progress& progress) override {
    survey_ = &survey;
    progress_ = &progress;
    VOLUTE_ASSIGN(plan_, floorPlan(first, survey.bounds, survey.height, survey.step));
    VOLUTE_TRY(checkFires(survey, plan_));
    shapes_ = first.shapes(plan_.origin[2]);
    for (std::size_t s = 0; s < survey.signs.size(); ++s)
      shown_.push_back(!signsOfStorey(first, {&survey.signs[s], 1}, plan_.origin[2]).empty());
    for (std::size_t i = 0; i < plan_.size(); ++i) {
      if (plan_.walkable(i)) {
        places_.push_back(i);
        eyes_.push_back(plan_.at(i));
      }
    }
    const Vec3 size = survey.bounds.size();
    if (eyes_.empty() && survey.step > std::max(size.x(), size.y())) {
      return failFor("step", ErrorCode::kInvalidArgument,
                     "no point of the plan is where people can be: points are {:g} m apart, and "
                     "the plan is {:g} by {:g} m; choose a smaller step",
                     survey.step, size.x(), size.y());
    }
    if (eyes_.empty()) {
      return failFor("height", ErrorCode::kInvalidArgument,
                     "nobody can look from z = {} m: the case knows smoke between z = {} "
                     "and {} m; expected a height where there is gas",
                     plainNumber(survey.height), plainNumber(survey.bounds.min[2]),
                     plainNumber(survey.bounds.max[2]));
    }
    const auto ofSmoke = std::ranges::count_if(survey.criteria, [](const Criterion& one) {
      return !one.law && one.quantity == Air::kExtinction;
    });
    const auto thicknesses =
        std::ranges::count_if(variations(), [](const Variation& one) { return one.smoke != 1; });
    const std::size_t levels =
        (survey.extinctionLimit > 0 ? 1 : 0) + static_cast<std::size_t>(ofSmoke * thicknesses);
    AirField air;
    if (!survey.criteria.empty())
      air = AirField::open(*survey.field, survey.criteria, survey.times.front());
    VOLUTE_TRY(survey.checkMemory(
        eyes_.size(),
        survey.sets.size() * SignLoss::kBytesOfSet +
            variations().size() * SignLoss::kBytesOfFactor +
            survey.signs.size() * SignLoss::kBytesOfSign + levels * LevelWatch::kBytesOfPlace +
            ExposureMeter::bytesOfPerson(air, survey.criteria, true) + kPlace +
            (survey.everywhere || !survey.fires.empty() ? 0 : SmokeColumn::kBytesOfEye)));
    if (const auto remark = survey.rset ? survey.rset->placesBeside(survey.bounds) : "";
        !remark.empty())
      progress.remark({RemarkCode::kDoubtful, remark});
    std::vector<double> floors;
    if (!survey.everywhere)
      floors = standOnFloors(first, survey.bounds, survey.height, eyes_, progress);
    use_ = planUse(survey, first, plan_, places_, eyes_, floors, progress);
    VOLUTE_ASSIGN(areas_, planAreas(survey, first, eyes_, progress));
    excludeAreas(progress);
    for (std::size_t i = 0; i < eyes_.size(); ++i) {
      if (use_.kinds[i] != PlanUse::Kind::kPeople)
        eyes_[i].z() = survey.height;  // of all places where nobody stands
      else if (eyes_[i].z() > survey.height)
        lifted_.push_back(i);
    }
    if (use_.fireUnknown)
      column_.emplace(plan_, places_, eyes_, floors);
    if (survey.maps == Survey::Maps::kSome && survey.times.size() > Survey::kPicturedTimes) {
      progress.remark(
          {RemarkCode::kNote,
           fmt::format("maps are drawn at {} of the {} stored times, and written as values (.vti) "
                       "at all",
                       Survey::kPicturedTimes, survey.times.size()),
           {Hint::set("maps", "all").so("draws all"), Hint::set("maps", "aset").so("draws none")}});
    } else if (survey.maps == Survey::Maps::kAll &&
               survey.signs.size() * survey.times.size() > 2000) {
      progress.remark({RemarkCode::kNote,
                       fmt::format("{} maps are drawn", survey.signs.size() * survey.times.size()),
                       {Hint::set("maps", "some")
                            .so(fmt::format("draws {} times of each sign", Survey::kPicturedTimes)),
                        Hint::set("frames").so("takes fewer times")}});
    }
    std::vector<std::vector<std::size_t>> members;
    for (const SignSet& set : survey.sets) members.push_back(set.members);
    std::vector<double> factors;
    for (const Variation& one : variations()) factors.push_back(one.onSigns());
    losses_.emplace(survey.signs, std::move(members), eyes_.size(), std::move(factors));
    if (survey.extinctionLimit > 0)
      local_.emplace(eyes_.size(), survey.extinctionLimit);
    if (!survey.criteria.empty())
      tenability_.emplace(survey, std::move(air), eyes_, use_, areas_, planValues(), shapes_,
                          shownSigns(survey.sets[0].members));
    if (tenability_ ? tenability_->smokeIsLate() : survey.beginsBefore()) {
      losses_->loseAll();
      progress.remark(
          {RemarkCode::kDoubtful,
           fmt::format(
               "the smoke is {} from {} s on, and the case begins before: "
               "what is lost until then is not known",
               survey.times.front() > survey.field->times().front() ? "looked at" : "stored",
               plainNumber(survey.times.front()))});
    }
    inView_.assign(survey.signs.size(), false);
    std::error_code error;
    std::filesystem::create_directory(survey.folder / "maps", error);
    series_.resize(survey.signs.size());
    return {};
  }

  std::vector<Vec3> eyes(double) const override { return eyes_; }

  bool wantsExtinction() const override { return column_.has_value(); }

  std::vector<Vec3> passed(double) const override {
    return column_ ? column_->below() : std::vector<Vec3>();
  }

  Status take(const SurveyTime& at) override {
    losses_->update(at.time, at.sightings);
    if (!at.stored)
      return {};
    noteInView(at);
    if (survey_->extinctionLimit > 0)
      updateLocal(at);
    if (column_)
      column_->update(at.time, at.extinction, at.passedHigh);
    if (survey_->maps != Survey::Maps::kNone) {
      for (std::size_t s = 0; s < series_.size(); ++s)
        series_[s].emplace_back(at.time, fmt::format("{}_{:04d}.vti", mapName(s), at.index));
    }
    ++index_;
    if (tenability_)
      VOLUTE_TRY(tenability_->take(at));
    return {};
  }

  Status draw(const SurveyTime& at, const SightSnapshot& snapshot) const override {
    if (survey_->maps == Survey::Maps::kNone)
      return {};
    return writeMaps(at, snapshot.shapes(plan_.origin[2]));
  }

  double end() const override { return tenability_ ? tenability_->end() : Watch::end(); }

  Result<std::string> finish(Json& report) override {
    if (survey_->endsAfter())
      VOLUTE_TRY(goOn());
    noteHidden();
    leaveOutHigherFloors();
    leaveOutColumn();
    tellOutOfSight();
    report["eyes"] = {{"kind", "plan"},           {"height", plan_.origin[2]},
                      {"step", plan_.step},       {"origin", {plan_.origin[0], plan_.origin[1]}},
                      {"nx", plan_.nx},           {"ny", plan_.ny},
                      {"walkable", eyes_.size()}, {"people", use_.count(PlanUse::Kind::kPeople)}};
    report["plan"] = walkable();
    report["plan_use"] = useRows();
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
      if (set > 0 && !showsAnything(set))
        continue;
      VOLUTE_ASSIGN(const auto figure,
                    htmlFigure(survey_->folder / asetName(set),
                               fmt::format("When {} seen any more.", setWords(set))));
      page += figure;
    }
    if (survey_->extinctionLimit > 0) {
      report["aset_local"] = {
          {"extinction", survey_->extinctionLimit},
          {"rows_interpolated", rowsOf(local_->times().answers(RoundTime::kNone))}};
      addTimes(report["aset_local"], "rows", local_->times(), survey_->round, asRows());
      arrays.push_back({"aset_local", overPlan(rounded(local_->times()))});
      VOLUTE_TRY(writeLocal());
      VOLUTE_ASSIGN(const auto figure,
                    htmlFigure(survey_->folder / "aset_local.png",
                               "Time at which the local extinction reaches the limit."));
      page += figure;
    }
    Json verdict = Json::array();
    addVerdict(verdict);
    const std::string sensitivity = addSensitivity(report);
    PlanTenability::Parts tenability;
    AreaFindings found{.eyes = eyes_, .people = use_.are(PlanUse::Kind::kPeople)};
    const LossTimes signs = sightLosses(losses_->earliest(0));
    const LossTimes latestSigns = sightLosses(losses_->latest(0));
    if (tenability_) {
      PlanTenability::Sight sight = sightOfSigns();
      for (std::size_t i = 0; i < variations().size(); ++i)
        sight.varied.push_back(losses_->earliest(survey_->sets.size() + i));
      VOLUTE_ASSIGN(tenability, tenability_->finish(sight, report, arrays, verdict));
      tenability_->find(found);
    } else {
      report["sources"] = sourcesJson(*survey_, nullptr);
      found.all = &signs;
      found.latest = &latestSigns;
    }
    found.single.insert(found.single.begin(), {"sight of signs", &signs, {}, &latestSigns});
    VOLUTE_ASSIGN(const auto areas, reportAreas(*survey_, areas_, found, emptyPicture(),
                                                planValues(), report, verdict));
    if (const std::string words = use_.words(); !words.empty()) {
      verdict.push_back(
          Json{{"criterion", "places"},
               {"sentence", fmt::format("Verdicts are of places where people are; {}.", words)}});
    }
    report["verdict"] = std::move(verdict);
    VOLUTE_TRY(writePlanVti(survey_->folder / "aset.vti", plan_, arrays));
    VOLUTE_TRY(writePlanCsv(survey_->folder / "maps.csv", plan_, arrays));
    VOLUTE_ASSIGN(const auto shown, shownMaps());
    // As ISO/TR 13387-1 and BS 7974 list what a report has: criteria, results, what they depend on.
    return tenability.criteria + areas + tenability.results +
           "<h2>Available safe egress time by visibility</h2>\n" + page + tenability.sensitivity +
           sensitivity + shown;
  }

 private:
  /// Where the smoke ends before the case does.
  Status goOn() {
    losses_->loseRest();
    for (std::size_t i = 0; local_ && i < eyes_.size(); ++i) local_->lose(i);
    return tenability_ ? tenability_->goOn() : Status();
  }

  /// Areas that are named as not for people.
  void excludeAreas(Progress& progress) {
    for (const PlanAreas::Area& area : areas_.areas) {
      if (area.people)
        continue;
      for (const std::size_t eye : area.eyes) use_.kinds[eye] = PlanUse::Kind::kNamed;
      use_.areas += (use_.areas.empty() ? "" : ", ") + area.name;
    }
    if (use_.count(PlanUse::Kind::kPeople) == 0)
      use_ = PlanUse::everybody(eyes_.size(), progress);
  }

  /// Without the variations.
  PlanTenability::Sight sightOfSigns() const {
    PlanTenability::Sight sight{losses_->earliest(0), losses_->latest(0), {}, hidden_[0]};
    sight.in.flip();
    return sight;
  }

  /// Eyes that were lifted to where the case stores not all that matters at any time: slices at the
  /// height of a storey say nothing about its stairs, which is said, and the others have a verdict.
  /// What is known until a file ends counts.
  void leaveOutHigherFloors() {
    std::vector<std::size_t> unknown;
    if (tenability_) {
      unknown = tenability_->notKnown(sightOfSigns(), lifted_);
    } else {
      const LossTimes losses = sightLosses(losses_->earliest(0));
      constexpr double kNever = -std::numeric_limits<double>::infinity();
      std::ranges::copy_if(lifted_, std::back_inserter(unknown),
                           [&](std::size_t eye) { return losses.known[eye] == kNever; });
    }
    if (unknown.size() == use_.count(PlanUse::Kind::kPeople))
      return;
    for (const std::size_t eye : unknown) use_.kinds[eye] = PlanUse::Kind::kHigher;
    if (tenability_)
      tenability_->count(use_);
  }

  /// The fire's own place where only the smoke says where it is.
  void leaveOutColumn() {
    if (!column_ || column_->eyes().empty())
      return;
    use_.findFire(column_->eyes(), column_->words());
    if (!use_.fireFound)
      return;
    progress_->remark({RemarkCode::kAssumed,
                       "the case does not state where it burns: " + column_->words() +
                           ", and verdicts are without these places",
                       {Hint::set("everywhere").so("counts them"),
                        Hint::set("fire_at").so("states where it burns")}});
    if (tenability_)
      tenability_->count(use_);
  }

  /// Of any sign, where one is in sight without smoke.
  LossTimes sightLosses(LossTimes losses) const {
    constexpr double kNever = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < eyes_.size(); ++i) {
      if (hidden_[0][i])
        losses.down[i] = losses.none[i] = losses.up[i] = losses.known[i] = kNever;
    }
    return losses;
  }

  PlanPicture emptyPicture() const {
    PlanPicture picture;
    picture.shapes = shapes_;
    picture.underlay = survey_->underlay;
    picture.north = survey_->north;
    picture.values.assign(plan_.size(), 0);
    picture.marks = emptyMarks(plan_);
    return picture;
  }

  /// Of places that are known; NaN of others.
  std::vector<double> rounded(const LossTimes& loss) const { return loss.answers(survey_->round); }

  std::function<Json(std::span<const Json>)> asRows() const {
    return [this](std::span<const Json> values) { return planValues().rowsOfJson(values); };
  }

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

  /// What a map of losses shows.
  std::string lossWords(std::size_t set) const {
    if (survey_->round == RoundTime::kUp)
      return fmt::format("First stored time at which {} seen", setWords(set));
    if (survey_->round == RoundTime::kNone)
      return fmt::format("Time from which {} seen, interpolated", setWords(set));
    const auto& members = survey_->sets[set].members;
    return "Last stored time at which " +
           (members.size() == 1 ? "sign " + survey_->signs[members[0]].sign.name
                                : (set == 0 ? "a sign" : "a sign of " + survey_->sets[set].name)) +
           " is seen";
  }

  /// Points from which no sign of a set is in sight at any time, smoke or not.
  void noteHidden() {
    for (std::size_t set = 0; set < survey_->sets.size(); ++set) {
      hidden_.push_back(losses_->inSight(set));
      hidden_.back().flip();
    }
  }

  /// Signs that can be seen from somewhere at some time.
  void noteInView(const SurveyTime& at) {
    for (std::size_t s = 0; s < inView_.size(); ++s) {
      if (!inView_[s])
        inView_[s] =
            std::ranges::any_of(at.sightings.subspan(s * eyes_.size(), eyes_.size()), inSight);
    }
  }

  std::string ofThePoints(std::ptrdiff_t count) const {
    return percentWords(static_cast<double>(count) / static_cast<double>(eyes_.size())) +
           " of the points";
  }

  /// " From 40 % of the points no sign is in sight, smoke or not."
  std::string hiddenWords() const {
    const auto count = std::ranges::count(hidden_[0], true);
    return count > 0
               ? fmt::format(" From {} no sign is in sight, smoke or not.", ofThePoints(count))
               : std::string();
  }

  /// What no verdict of signs is of.
  void tellOutOfSight() const {
    for (std::size_t s = 0; s < inView_.size(); ++s) {
      if (shown_[s] && !inView_[s])
        progress_->remark({RemarkCode::kDoubtful,
                           fmt::format("sign '{}' is in sight from no point of the plan, smoke or "
                                       "not: is it covered, or does it face a wall?",
                                       survey_->signs[s].sign.name)});
    }
    const auto later = std::ranges::count(losses_->inSightLater(0), true);
    if (later > 0)
      progress_->remark(
          {RemarkCode::kAssumed,
           fmt::format("from {} a sign comes into sight after {} s, where something opens: that "
                       "none is before counts as no loss",
                       ofThePoints(later), plainNumber(survey_->times.front()))});
  }

  /// Whether a map of a set could show anything.
  bool showsAnything(std::size_t set) const {
    return std::ranges::any_of(survey_->sets[set].members,
                               [&](std::size_t s) { return inView_[s]; });
  }

  /// Those of some signs that are on the plan's storey, for maps.
  std::vector<SightTarget> shownSigns(std::span<const std::size_t> members) const {
    std::vector<SightTarget> signs;
    for (const std::size_t s : members) {
      if (shown_[s])
        signs.push_back(survey_->signs[s]);
    }
    return signs;
  }

  /// As far as that is known: what is not covered may be.
  static bool inSight(const Sighting& sighting) { return !sighting.blocked && sighting.limit > 0; }

  void updateLocal(const SurveyTime& at) { local_->update(at.time, at.extinction); }

  std::vector<float> overPlan(std::span<const double> values) const {
    return planValues().cells(values);
  }

  template <class Value>
  std::vector<float> mapOf(const SurveyTime& at, std::size_t sign, Value&& value) const {
    std::vector<float> out(plan_.size(), kNoFloat);
    for (std::size_t i = 0; i < places_.size(); ++i)
      out[places_[i]] = static_cast<float>(value(at.sightings[sign * eyes_.size() + i]));
    return out;
  }

  PlanPicture visibilityMap(const SurveyTime& at, std::size_t s,
                            std::vector<PlanShape> shapes) const {
    const SafetySign& sign = survey_->signs[s].sign;
    PlanPicture picture;
    picture.title = fmt::format("{} at {} s, seen from z = {} m", sign.name,
                                plainNumber(at.time, 4), plainNumber(plan_.origin[2]));
    picture.subtitle = fmt::format("S = C / mean K, {} C = {:.4g}, angle {}", sign.law.name,
                                   sign.law.c, nameOf(sign.angle));
    picture.barLabel = "visibility S [m]";
    picture.high = kFar;
    picture.highIsMore = true;
    picture.shapes = std::move(shapes);
    picture.underlay = survey_->underlay;
    picture.north = survey_->north;
    picture.values.assign(plan_.size(), 0);
    picture.marks = emptyMarks(plan_);
    for (std::size_t i = 0; i < places_.size(); ++i) {
      const Sighting& sighting = at.sightings[s * eyes_.size() + i];
      picture.values[places_[i]] = sighting.visibility();
      picture.marks[places_[i]] = sighting.visible     ? PlanMark::kValue
                                  : !inSight(sighting) ? PlanMark::kHidden
                                  : sighting.covered   ? PlanMark::kLost
                                                       : PlanMark::kUnknown;
    }
    picture.words = {{PlanMark::kLost, "lost in the smoke"},
                     {PlanMark::kHidden, "sign not in sight: wall, or seen from behind"},
                     {PlanMark::kUnknown, kNoData},
                     {PlanMark::kSolid, kSolidWords}};
    return picture;
  }

  Status writeMaps(const SurveyTime& at, const std::vector<PlanShape>& shapes) const {
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
                        of("mean_extinction", [](const Sighting& x) { return x.meanExtinction(); }),
                        of("visibility", [](const Sighting& x) { return x.visibility(); }),
                        of("blocked", [](const Sighting& x) { return x.blocked ? 1 : 0; }),
                        of("visible", [](const Sighting& x) { return x.visible ? 1 : 0; })});
      if (done[s] && survey_->pictured(at.index)) {
        const std::span one(&survey_->signs[s], shown_[s] ? 1 : 0);
        done[s] = writeImage(folder / (name + ".png"),
                             drawPlan(plan_, visibilityMap(at, s, shapes), one));
      }
    });
    for (Status& status : done) VOLUTE_TRY(std::move(status));
    return {};
  }

  PlanValues planValues() const { return {&plan_, places_, survey_->parts.get()}; }

  Json rowsOf(std::span<const double> values) const { return planValues().rows(values); }

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

  /// Rows of p (people are there), v (nothing below), f (the fire's own place), l (low head room),
  /// u (upon furniture), n (in an area named as not for people), h (on a higher floor, where the
  /// air is not known) and - (solid).
  Json useRows() const {
    std::string all(plan_.size(), '-');
    for (std::size_t i = 0; i < places_.size(); ++i)
      all[places_[i]] = "pvflunh"[static_cast<std::size_t>(use_.kinds[i])];
    Json rows = Json::array();
    for (int y = 0; y < plan_.ny; ++y) {
      rows.push_back(all.substr(static_cast<std::size_t>(y) * static_cast<std::size_t>(plan_.nx),
                                static_cast<std::size_t>(plan_.nx)));
    }
    return rows;
  }

  /// Where people are and see a sign of a set where there is no smoke.
  std::vector<bool> countsOf(std::size_t set) const {
    std::vector<bool> counts = use_.are(PlanUse::Kind::kPeople);
    for (std::size_t i = 0; i < counts.size(); ++i) counts[i] = counts[i] && !hidden_[set][i];
    return counts;
  }

  Json asetJson(std::size_t set) const {
    const LossTimes loss = losses_->times(set);
    Json names = Json::array();
    for (const std::size_t s : survey_->sets[set].members)
      names.push_back(survey_->signs[s].sign.name);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < loss.up.size(); ++i)
      kept += loss.complete(i) && std::isinf(loss.up[i]) ? 1 : 0;
    const auto out = std::ranges::count(hidden_[set], true);
    Json json = {{"set", survey_->sets[set].name},
                 {"signs", names},
                 {"kept_to_the_end", kept},
                 {"never_in_sight", out},
                 {"rows_interpolated", rowsOf(loss.answers(RoundTime::kNone))},
                 {"rows_down", rowsOf(loss.answers(RoundTime::kDown))},
                 {"rows_up", rowsOf(loss.answers(RoundTime::kUp))},
                 {"rows_earliest", rowsOf(rounded(losses_->earliest(set)))},
                 {"rows_latest", rowsOf(rounded(losses_->latest(set)))}};
    addTimes(json, "rows", loss, survey_->round, asRows());
    return json;
  }

  void addArrays(std::size_t set, std::vector<PlanArray>& arrays) const {
    const std::string name =
        set == 0 ? "" : fmt::format("_{}_{}", set, Survey::fileName(survey_->sets[set].name));
    arrays.push_back({"aset" + name, overPlan(rounded(losses_->times(set)))});
    arrays.push_back(
        {"aset_interpolated" + name, overPlan(losses_->times(set).answers(RoundTime::kNone))});
    arrays.push_back({"aset_earliest" + name, overPlan(rounded(losses_->earliest(set)))});
    arrays.push_back({"aset_latest" + name, overPlan(rounded(losses_->latest(set)))});
  }

  PlanPicture lossPicture(const LossTimes& times) const {
    PlanPicture picture = emptyPicture();
    picture.barLabel = "time [s]";
    picture.stored = true;
    picture.low = survey_->times.front();
    picture.high = std::max(survey_->end, picture.low + 1e-9);
    for (std::size_t i = 0; i < places_.size(); ++i) {
      const double time = times.by(survey_->round)[i];
      picture.values[places_[i]] = time;
      picture.marks[places_[i]] = !times.complete(i) ? PlanMark::kUnknown
                                  : std::isinf(time) ? PlanMark::kKept
                                                     : PlanMark::kValue;
    }
    return picture;
  }

  Status writeAset(std::size_t set) const {
    PlanPicture picture = lossPicture(losses_->times(set));
    for (std::size_t i = 0; i < places_.size(); ++i) {
      if (hidden_[set][i])
        picture.marks[places_[i]] = PlanMark::kHidden;
    }
    picture.title = fmt::format("{}, from z = {} m", lossWords(set), plainNumber(plan_.origin[2]));
    picture.subtitle = lawsOf(set);
    picture.words = {{PlanMark::kKept, fmt::format("never lost: still seen at {} s, the last time",
                                                   plainNumber(survey_->end))},
                     {PlanMark::kHidden, "no sign in sight, smoke or not"},
                     {PlanMark::kUnknown, kNotKnownWords},
                     {PlanMark::kSolid, kSolidWords}};
    return writePlan(survey_->folder / asetName(set), plan_, picture,
                     shownSigns(survey_->sets[set].members));
  }

  /// How the first loss of all signs depends on what is not known well.
  std::string addSensitivity(Json& report) const {
    const std::vector<bool> counts = countsOf(0);
    std::vector<HtmlRow> rows;
    Json list = Json::array();
    const auto add = [&](const std::string& name, const LossTimes& times) {
      const FirstLoss loss = firstLoss(times, survey_->round, counts);
      const bool any = loss.any && loss.certain();
      const char* none = loss.certain() ? "\u2013" : "not known";
      list.push_back({{"variation", name},
                      {"first_loss", any ? Json(loss.by(survey_->round)) : Json()},
                      {"first_loss_interpolated", any ? Json(loss.none) : Json()},
                      {"known", knownJson(loss.known)},
                      {"share_lost", loss.share}});
      rows.push_back({name, any ? plainNumber(loss.by(survey_->round), 4) : none,
                      any ? plainNumber(loss.none, 4) : none,
                      fmt::format("{:.1f} %", 100 * loss.share)});
    };
    add("as computed", losses_->times(0));
    add("at the largest depths that the files' rounding allows (the verdict)",
        losses_->earliest(0));
    add("at the smallest", losses_->latest(0));
    for (std::size_t i = 0; i < variations().size(); ++i)
      add(std::string(variations()[i].name), losses_->times(survey_->sets.size() + i));
    report["sensitivity"] = std::move(list);
    return "<h2>Sensitivity of the visibility of signs</h2>\n" +
           htmlTable({"", "first loss of all signs [s]", "interpolated [s]",
                      "places that lose them until the end"},
                     rows, HtmlAlign::kNumbers);
  }

  /// Which sign is lost first, and when; by the largest depths that the files allow.
  void addVerdict(Json& verdict) const {
    const std::size_t single = survey_->sets.size() > 1 ? 1 : 0;
    const std::size_t singles = survey_->sets.size() > 1 ? survey_->signs.size() : 1;
    const auto lossOf = [&](std::size_t set) {
      return firstLoss(losses_->earliest(set), survey_->round, countsOf(set));
    };
    const auto latestOf = [&](std::size_t set) {
      return firstLoss(losses_->latest(set), survey_->round, countsOf(set));
    };
    // What may be lost sooner is worse, whether it is certain or not.
    const auto sooner = [&](const FirstLoss& one, const FirstLoss& other) {
      const auto time = [&](const FirstLoss& loss) {
        return !loss.certain() ? loss.known
               : loss.any      ? loss.by(survey_->round)
                               : std::numeric_limits<double>::infinity();
      };
      return time(one) < time(other);
    };
    std::size_t soonest = single;
    FirstLoss soonestLoss = lossOf(single);
    for (std::size_t set = single + 1; set < single + singles; ++set) {
      const FirstLoss loss = lossOf(set);
      if (sooner(loss, soonestLoss)) {
        soonest = set;
        soonestLoss = loss;
      }
    }
    const double end = survey_->end;
    const std::string name = survey_->signs[survey_->sets[soonest].members[0]].sign.name;
    constexpr const char* kSeeing = "the points that see it without smoke";
    const auto uncertain = [&](const std::string& what, const FirstLoss& loss) {
      return fmt::format("{}: {}{}.", what, unknownWords(loss, "lost", kSeeing),
                         loss.any
                             ? fmt::format("; lost at the latest at {} s, from {}",
                                           plainNumber(loss.up, 4), placeWords(eyes_[loss.place]))
                             : "");
    };
    verdict.push_back(verdictJson(
        "sign lost first",
        !soonestLoss.certain() ? uncertain(fmt::format("Sight of sign '{}'", name), soonestLoss)
        : soonestLoss.any
            ? fmt::format("Sign '{}' is lost first: at {}, from {}; by {} s it is lost from "
                          "{} of the points that see it without smoke.{}",
                          name, timeWords(soonestLoss, survey_->round),
                          placeWords(eyes_[soonestLoss.place]), plainNumber(end),
                          percentWords(soonestLoss.share),
                          latestWords(soonestLoss, latestOf(soonest), "lost"))
            : fmt::format("No sign is lost from anywhere until {} s.{}", plainNumber(end),
                          hiddenWords()),
        soonestLoss, survey_->round, eyes_));
    verdict.back()["sign"] = soonestLoss.any || !soonestLoss.certain() ? Json(name) : Json();
    if (survey_->sets.size() > 1) {
      const FirstLoss all = lossOf(0);
      verdict.push_back(verdictJson(
          "sight of signs",
          !all.certain() ? uncertain("Sight of any sign", all)
          : all.any ? fmt::format("From {} no sign is visible from {} on; by {} s this holds for "
                                  "{} of the points that see a sign without smoke.{}",
                                  placeWords(eyes_[all.place]), timeWords(all, survey_->round),
                                  plainNumber(end), percentWords(all.share),
                                  latestWords(all, latestOf(0), "lost"))
                    : fmt::format("Every point that sees a sign without smoke sees one until {} s.",
                                  plainNumber(end)),
          all, survey_->round, eyes_));
    }
  }

  std::string lawsOf(std::size_t set) const {
    std::vector<std::string> laws;
    for (const std::size_t s : survey_->sets[set].members) {
      const VisibilityLaw& law = survey_->signs[s].sign.law;
      const auto text = fmt::format("{} C = {:.4g}", law.name, law.c);
      if (std::ranges::find(laws, text) == laws.end())
        laws.push_back(text);
    }
    return fmt::format("lost where the optical depth exceeds C: {}", fmt::join(laws, ", "));
  }

  Status writeLocal() const {
    PlanPicture picture = lossPicture(local_->times());
    picture.title = fmt::format(
        "{} {:g} 1/m at z = {} m",
        survey_->round == RoundTime::kDown ? "Last stored time with K <" : "First time with K >=",
        survey_->extinctionLimit, plainNumber(plan_.origin[2]));
    picture.subtitle = "smoke where one stands, signs aside";
    picture.words = {{PlanMark::kKept,
                      fmt::format("below it at {} s, the last time", plainNumber(survey_->end))},
                     {PlanMark::kUnknown, kNotKnownWords},
                     {PlanMark::kSolid, kSolidWords}};
    return writePlan(survey_->folder / "aset_local.png", plan_, picture,
                     shownSigns(survey_->sets[0].members));
  }

  /// Maps at a few times in the page.
  Result<std::string> shownMaps() const {
    if (survey_->maps == Survey::Maps::kNone || index_ == 0)
      return std::string();
    std::string page = "<h2>Visibility of each sign</h2>\n";
    std::vector<int> drawn;
    for (int i = 0; i < index_; ++i) {
      if (survey_->pictured(static_cast<std::size_t>(i)))
        drawn.push_back(i);
    }
    const std::size_t count = drawn.size();
    std::vector<int> shown{drawn[0], drawn[count / 3], drawn[2 * count / 3], drawn[count - 1]};
    shown.erase(std::ranges::unique(shown).begin(), shown.end());
    constexpr std::size_t kMax = 6;
    std::size_t figures = 0;
    std::string hidden;
    for (std::size_t s = 0; s < survey_->signs.size(); ++s) {
      if (!inView_[s]) {
        hidden += (hidden.empty() ? "" : ", ") + escapedHtml(survey_->signs[s].sign.name);
        continue;
      }
      if (++figures > kMax)
        continue;
      for (const int i : shown) {
        const auto file = survey_->folder / "maps" / fmt::format("{}_{:04d}.png", mapName(s), i);
        VOLUTE_ASSIGN(
            const auto figure,
            htmlFigure(file,
                       fmt::format("{} at {} s", survey_->signs[s].sign.name,
                                   plainNumber(survey_->times[static_cast<std::size_t>(i)]))));
        page += figure;
      }
    }
    if (!hidden.empty())
      page += fmt::format("<p>In view from no point of this plan at any time: {}.</p>\n", hidden);
    if (figures > kMax)
      page += fmt::format("<p>Maps of {} more signs are in the folder maps.</p>\n", figures - kMax);
    return page;
  }

  const Survey* survey_ = nullptr;
  Progress* progress_ = nullptr;
  FloorPlan plan_;
  std::vector<std::size_t> places_;  // of each eye in the plan
  std::vector<Vec3> eyes_;
  std::vector<std::size_t> lifted_;  // of eyes_, above floors that are higher than the plan's
  std::optional<SignLoss> losses_;
  PlanUse use_;
  std::optional<SmokeColumn> column_;  // where it is not known where it burns
  PlanAreas areas_;
  std::vector<std::vector<bool>> hidden_;  // of each set
  std::vector<bool> inView_;               // of each sign
  std::optional<LevelWatch> local_;
  std::optional<PlanTenability> tenability_;
  std::vector<PlanShape> shapes_;  // at the first time
  std::vector<bool> shown_;        // of each sign: it is on the plan's storey
  std::vector<std::vector<std::pair<double, std::string>>> series_;  // of each sign
  int index_ = 0;
};

}  // namespace

std::unique_ptr<Watch> planWatch() {
  return std::make_unique<PlanWatch>();
}

}  // namespace volute
