// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/plan_tenability.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "volute/report/page.hpp"
#include "volute/visibility/plan_picture.hpp"
#include "volute/visibility/verdict.hpp"

namespace volute {
namespace {

constexpr double kNotReached = std::numeric_limits<double>::infinity();
constexpr double kNoTime = std::numeric_limits<double>::quiet_NaN();
constexpr const char* kSight = "sight of signs";

std::string listOf(const std::vector<Air>& all) {
  std::string text;
  for (const Air one : all) text += (text.empty() ? "" : ", ") + std::string(quantityOf(one).name);
  return text;
}

/// Colours that people with defects of colour vision tell apart (Okabe and Ito 2008), as displays
/// show them.
Rgb kindColor(std::size_t i) {
  static const std::array<Rgb, 8> colors{
      Rgb(0.34, 0.71, 0.91), Rgb(0.90, 0.62, 0.0), Rgb(0.0, 0.62, 0.45),  Rgb(0.94, 0.89, 0.26),
      Rgb(0.0, 0.45, 0.70),  Rgb(0.84, 0.37, 0.0), Rgb(0.80, 0.47, 0.65), Rgb(0.35, 0.35, 0.35)};
  return colors[i % colors.size()];
}

}  // namespace

Json criteriaJson(const ExposureMeter& meter) {
  Json list = Json::array();
  for (std::size_t c = 0; c < meter.criteria().size(); ++c) {
    const Criterion& criterion = meter.criteria()[c];
    Json json = {{"name", criterion.name},
                 {"criterion", criterion.words()},
                 {"limit", criterion.limit},
                 {"unit", criterion.unit()},
                 {"source_of_limit", criterion.source},
                 {"source_checked", criterion.checked}};
    if (criterion.law) {
      const DoseLawInfo& info = infoOf(*criterion.law);
      json["model"] = {
          {"name", info.name}, {"source", info.source}, {"compared_with", info.checked}};
    }
    json["from"] = Json::array();
    for (const Air one : criterion.needed()) {
      if (!meter.air().description(one).empty())
        json["from"].push_back(meter.air().description(one));
    }
    for (const Air one : criterion.taken()) {
      if (!meter.air().description(one).empty())
        json["from"].push_back(meter.air().description(one));
    }
    json["counted_as_in_clean_air"] = listOf(meter.assumed(c));
    list.push_back(std::move(json));
  }
  for (const ExposureMeter::Missing& one : meter.missing())
    list.push_back(Json{{"name", one.criterion.name},
                        {"criterion", one.criterion.words()},
                        {"not_assessed", one.why}});
  return list;
}

std::string criteriaTable(const ExposureMeter& meter) {
  std::vector<HtmlRow> rows;
  for (const Json& one : criteriaJson(meter)) {
    if (one.contains("not_assessed")) {
      rows.push_back({htmlOf(one["name"]), htmlOf(one["criterion"]),
                      "<b>not assessed</b>: " + htmlOf(one["not_assessed"]), ""});
      continue;
    }
    std::string from;
    for (const Json& source : one["from"]) from += (from.empty() ? "" : "; ") + htmlOf(source);
    if (from.empty())
      from = "the smoke";
    if (one["counted_as_in_clean_air"] != "")
      from += "; not stored, counted as in clean air: " + htmlOf(one["counted_as_in_clean_air"]);
    std::string source = htmlOf(one["source_of_limit"]) +
                         (one["source_checked"] == true ? "" : " <b>(limit not checked)</b>");
    if (one.contains("model"))
      source += "; " + htmlOf(one["model"]["source"]);
    rows.push_back({htmlOf(one["name"]), htmlOf(one["criterion"]), from, source});
  }
  return "<h2>Criteria of tenability</h2>\n" +
         htmlTable({"name", "untenable when", "from", "source"}, rows);
}

PlanTenability::PlanTenability(const Survey& survey, std::span<const Vec3> eyes, PlanValues values,
                               std::vector<PlanShape> shapes, std::vector<SightTarget> signs)
    : survey_(&survey),
      eyes_(eyes),
      values_(values),
      shapes_(std::move(shapes)),
      signs_(std::move(signs)),
      meter_(AirField::open(*survey.field, survey.criteria), survey.criteria, eyes.size()) {}

Status PlanTenability::take(const SurveyTime& at) {
  if (!at.stored)
    return {};
  return meter_.advance(
      at.time, [&](double, std::span<Vec3> places) { std::ranges::copy(eyes_, places.begin()); },
      at.extinction);
}

/// The first of all criteria at each point.
void PlanTenability::combine(const LossTimes& signs, const std::vector<bool>& inSight) {
  all_ = LossTimes(eyes_.size());
  which_.assign(eyes_.size(), -1);
  const auto add = [&](const LossTimes& times, std::size_t i, int which) {
    // Criteria are compared by what is the best guess of each; the first is rounded then.
    const bool sooner = times.none[i] < all_.none[i];
    all_.down[i] = std::min(all_.down[i], times.down[i]);
    all_.none[i] = std::min(all_.none[i], times.none[i]);
    all_.up[i] = std::min(all_.up[i], times.up[i]);
    if (sooner)
      which_[i] = which;
  };
  for (std::size_t i = 0; i < eyes_.size(); ++i) {
    if (inSight[i])
      add(signs, i, 0);
    for (std::size_t c = 0; c < meter_.criteria().size(); ++c)
      add(meter_.times(c), i, static_cast<int>(c) + 1);
  }
}

Json PlanTenability::criterionJson(std::size_t c) const {
  const LossTimes& times = meter_.times(c);
  std::size_t unknown = 0;
  std::vector<double> worst(meter_.worst(c).begin(), meter_.worst(c).end());
  for (std::size_t i = 0; i < eyes_.size(); ++i) {
    if (meter_.unknown(c, i)) {
      ++unknown;
      worst[i] = kNoTime;
    }
  }
  return {{"points_without_data", unknown},
          {"rows", values_.rows(times.by(survey_->round))},
          {"rows_interpolated", values_.rows(times.none)},
          {"rows_down", values_.rows(times.down)},
          {"rows_up", values_.rows(times.up)},
          {meter_.criteria()[c].isDose() ? "dose_at_the_end" : "worst_value", values_.rows(worst)}};
}

Json PlanTenability::sentence(std::size_t c) const {
  const Criterion& criterion = meter_.criteria()[c];
  const FirstLoss first = firstLoss(meter_.times(c), survey_->round);
  std::size_t unknown = 0;
  for (std::size_t i = 0; i < eyes_.size(); ++i) unknown += meter_.unknown(c, i);
  std::string text = first.any
                         ? fmt::format(
                               "{} is first reached at {}, at {}; by {:g} s at {:.0f} % of the "
                               "floor.",
                               criterion.words(), timeWords(first), placeWords(eyes_[first.place]),
                               survey_->times.back(), 100 * first.share)
                         : fmt::format("{} is not reached anywhere until {:g} s.",
                                       criterion.words(), survey_->times.back());
  if (unknown > 0) {
    text += fmt::format(" At {:.0f} % of the floor the case stores no data for it.",
                        100 * static_cast<double>(unknown) / static_cast<double>(eyes_.size()));
  }
  return verdictJson(criterion.name, text, first, survey_->round, eyes_);
}

PlanPicture PlanTenability::emptyPicture(std::string title) const {
  PlanPicture picture;
  picture.title = std::move(title);
  picture.shapes = shapes_;
  picture.underlay = survey_->underlay;
  picture.north = survey_->north;
  picture.values.assign(values_.plan->size(), 0);
  picture.marks = emptyMarks(*values_.plan);
  return picture;
}

Status PlanTenability::writeTimes(const std::string& name, const std::string& title,
                                  std::span<const double> times,
                                  const std::function<bool(std::size_t)>& unknown) const {
  PlanPicture picture = emptyPicture(title);
  picture.barLabel = "time [s]";
  picture.stored = true;
  picture.low = survey_->times.front();
  picture.high = std::max(survey_->times.back(), picture.low + 1e-9);
  for (std::size_t i = 0; i < eyes_.size(); ++i) {
    picture.values[values_.places[i]] = times[i];
    picture.marks[values_.places[i]] = !std::isinf(times[i]) ? PlanMark::kValue
                                       : unknown(i)          ? PlanMark::kUnknown
                                                             : PlanMark::kKept;
  }
  picture.words = {
      {PlanMark::kKept, fmt::format("not reached at {:g} s, the last time", survey_->times.back())},
      {PlanMark::kUnknown, kNoData},
      {PlanMark::kSolid, kSolidWords}};
  return writePlan(survey_->folder / name, *values_.plan, picture, signs_);
}

Status PlanTenability::writeFirst() const {
  PlanPicture picture = emptyPicture(
      fmt::format("Which criterion is reached first, at z = {:g} m", values_.plan->origin[2]));
  picture.kinds.emplace_back(kindColor(0), kSight);
  for (std::size_t c = 0; c < meter_.criteria().size(); ++c)
    picture.kinds.emplace_back(kindColor(c + 1), meter_.criteria()[c].name);
  for (std::size_t i = 0; i < eyes_.size(); ++i) {
    picture.values[values_.places[i]] = std::max(which_[i], 0);
    bool unknown = false;
    for (std::size_t c = 0; c < meter_.criteria().size(); ++c) unknown |= meter_.unknown(c, i);
    picture.marks[values_.places[i]] = which_[i] >= 0 ? PlanMark::kValue
                                       : unknown      ? PlanMark::kUnknown
                                                      : PlanMark::kKept;
  }
  picture.words = {
      {PlanMark::kKept, fmt::format("none until {:g} s, the last time", survey_->times.back())},
      {PlanMark::kUnknown, kNoData},
      {PlanMark::kSolid, kSolidWords}};
  return writePlan(survey_->folder / "tenability_first.png", *values_.plan, picture, signs_);
}

Result<std::string> PlanTenability::margin(Json& report, std::vector<PlanArray>& arrays,
                                           Json& verdict) {
  if (!survey_->rset)
    return std::string();
  const std::vector<double> rset = survey_->rset->at(eyes_, std::max(survey_->step, 0.5));
  std::vector<double> margin(rset.size());
  const std::vector<double>& aset = all_.by(survey_->round);
  std::size_t worst = rset.size(), needed = 0, tooLate = 0;
  for (std::size_t i = 0; i < rset.size(); ++i) {
    margin[i] = aset[i] - rset[i];
    if (std::isnan(rset[i]))
      continue;
    ++needed;
    tooLate += margin[i] < 0;
    if (worst == rset.size() || margin[i] < margin[worst])
      worst = i;
  }
  report["rset"] = {{"from", survey_->rset->description()}, {"rows", values_.rows(rset)}};
  report["margin"] = {
      {"rows", values_.rows(margin)}, {"points_needed", needed}, {"points_too_late", tooLate}};
  arrays.push_back({"rset", values_.cells(rset)});
  arrays.push_back({"margin", values_.cells(margin)});
  std::string text;
  if (worst == rset.size()) {
    text = "RSET: no point of this plan is in use.";
  } else if (std::isinf(margin[worst])) {
    text = fmt::format(
        "ASET - RSET: no criterion is reached until {:g} s where people are (RSET: {}).",
        survey_->times.back(), survey_->rset->description());
    if (rset[worst] > survey_->times.back())
      text +=
          " But RSET is later than the last time of the case, so the result is unknown until "
          "then.";
  } else {
    const double least = all_.down[worst] - rset[worst], most = all_.up[worst] - rset[worst];
    text = fmt::format(
        "ASET - RSET: the smallest margin is {:.4g} s (by stored times {:.4g} to "
        "{:.4g} s) at {}; at {:.0f} % of the points in use, people leave too late "
        "(RSET: {}).",
        margin[worst], least, most, placeWords(eyes_[worst]),
        100.0 * static_cast<double>(tooLate) / static_cast<double>(needed),
        survey_->rset->description());
    report["margin"]["least"] =
        Json{{"value", margin[worst]},
             {"down", least},
             {"up", most},
             {"position", {eyes_[worst][0], eyes_[worst][1], eyes_[worst][2]}}};
  }
  verdict.push_back(Json{{"criterion", "margin"}, {"sentence", text}});
  std::vector<double> finite;
  for (const double one : margin) {
    if (std::isfinite(one))
      finite.push_back(one);
  }
  if (finite.empty())
    return std::string();
  PlanPicture picture =
      emptyPicture(fmt::format("ASET - RSET at z = {:g} m", values_.plan->origin[2]));
  picture.subtitle = survey_->rset->description();
  picture.barLabel = "margin [s]";
  picture.low = *std::ranges::min_element(finite);
  picture.high = std::max(*std::ranges::max_element(finite), picture.low + 1e-9);
  for (std::size_t i = 0; i < margin.size(); ++i) {
    picture.values[values_.places[i]] = margin[i];
    picture.marks[values_.places[i]] = std::isnan(margin[i])   ? PlanMark::kHidden
                                       : std::isinf(margin[i]) ? PlanMark::kKept
                                                               : PlanMark::kValue;
  }
  picture.words = {{PlanMark::kKept, "no criterion is reached"},
                   {PlanMark::kHidden, "nobody comes here"},
                   {PlanMark::kUnknown, kNoData},
                   {PlanMark::kSolid, kSolidWords}};
  VOLUTE_TRY(writePlan(survey_->folder / "margin.png", *values_.plan, picture, signs_));
  return htmlFigure(survey_->folder / "margin.png",
                    "Margin: available minus required safe egress "
                    "time.");
}

Result<std::string> PlanTenability::finish(const LossTimes& signs, const std::vector<bool>& inSight,
                                           Json& report, std::vector<PlanArray>& arrays,
                                           Json& verdict) {
  combine(signs, inSight);
  Json json = Json::object();
  json["criteria"] = criteriaJson(meter_);
  std::string page = volute::criteriaTable(meter_);
  std::string figures;
  for (std::size_t c = 0; c < meter_.criteria().size(); ++c) {
    const Criterion& criterion = meter_.criteria()[c];
    json["criteria"][c].update(criterionJson(c));
    verdict.push_back(sentence(c));
    const std::string name = Survey::fileName(criterion.name);
    arrays.push_back({"aset_" + name, values_.cells(meter_.times(c).by(survey_->round))});
    arrays.push_back({"worst_" + name, values_.cells(meter_.worst(c))});
    const auto& times = meter_.times(c).by(survey_->round);
    if (std::ranges::all_of(times, [](double time) { return std::isinf(time); }))
      continue;
    const std::string file = "tenability_" + name + ".png";
    VOLUTE_TRY(writeTimes(
        file, fmt::format("When {} at z = {:g} m", criterion.words(), values_.plan->origin[2]),
        times, [&](std::size_t i) { return meter_.unknown(c, i); }));
    VOLUTE_ASSIGN(const auto figure, htmlFigure(survey_->folder / file, criterion.words()));
    figures += figure;
  }
  const std::vector<double>& all = all_.by(survey_->round);
  std::vector<std::string> names(eyes_.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (which_[i] >= 0)
      names[i] =
          which_[i] == 0 ? kSight : meter_.criteria()[static_cast<std::size_t>(which_[i]) - 1].name;
  }
  json["aset"] = {{"rows", values_.rows(all)},
                  {"rows_interpolated", values_.rows(all_.none)},
                  {"rows_down", values_.rows(all_.down)},
                  {"rows_up", values_.rows(all_.up)},
                  {"rows_of_the_first_criterion", values_.rowsOfText(names)}};
  arrays.push_back({"aset_all", values_.cells(all)});
  const FirstLoss first = firstLoss(all_, survey_->round);
  const std::string by = first.any ? names[first.place] : "";
  verdict.insert(
      verdict.begin(),
      verdictJson("all",
                  first.any ? fmt::format("ASET of all criteria: {}, by {}, at {}.",
                                          timeWords(first), by, placeWords(eyes_[first.place]))
                            : fmt::format("ASET of all criteria: none is reached "
                                          "until {:g} s.",
                                          survey_->times.back()),
                  first, survey_->round, eyes_));
  VOLUTE_TRY(writeTimes("aset_all.png",
                        fmt::format("ASET of all criteria at z = {:g} m", values_.plan->origin[2]),
                        all, [](std::size_t) { return false; }));
  VOLUTE_TRY(writeFirst());
  VOLUTE_ASSIGN(const auto times, htmlFigure(survey_->folder / "aset_all.png",
                                             "When the first of all criteria is reached."));
  VOLUTE_ASSIGN(const auto kinds, htmlFigure(survey_->folder / "tenability_first.png",
                                             "Which criterion is reached first."));
  VOLUTE_ASSIGN(const auto left, margin(json, arrays, verdict));
  report["tenability"] = std::move(json);
  return page + "<h2>Tenability</h2>\n" + times + kinds + left + figures;
}

}  // namespace volute
