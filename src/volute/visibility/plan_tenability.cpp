// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/plan_tenability.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>

#include "volute/base/plain_number.hpp"
#include "volute/report/page.hpp"
#include "volute/visibility/plan_picture.hpp"
#include "volute/visibility/sensitivity.hpp"
#include "volute/visibility/verdict.hpp"

namespace volute {
namespace {

constexpr double kNoTime = std::numeric_limits<double>::quiet_NaN();
constexpr const char* kSight = "sight of signs";

std::string listOf(const std::vector<Air>& all) {
  std::string text;
  for (const Air one : all) text += (text.empty() ? "" : ", ") + std::string(quantityOf(one).name);
  return text;
}

/// Until when each place is known, as arrays have it: infinite all along, NaN never.
std::vector<double> knownUntil(const LossTimes& times) {
  std::vector<double> until = times.known;
  for (double& one : until) one = std::isinf(one) && one < 0 ? kNoTime : one;
  return until;
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

void addTimes(Json& json, const std::string& key, const LossTimes& times, RoundTime round,
              const std::function<Json(std::span<const Json>)>& list) {
  const std::size_t places = times.up.size();
  const auto answers = times.answers(round);
  std::vector<Json> time, known, latest;
  bool any = false;
  for (std::size_t i = 0; i < places; ++i) {
    time.push_back(jsonNumber(answers[i]));
    known.push_back(knownJson(times.known[i]));
    const bool late = !times.complete(i) && !std::isinf(times.up[i]);
    latest.push_back(late ? jsonNumber(times.up[i]) : Json());
    any |= late;
  }
  json[key] = list(time);
  json[key + "_known"] = list(known);
  if (any)
    json[key + "_at_the_latest"] = list(latest);
}

Json sourcesJson(const Survey& survey, const ExposureMeter* meter) {
  Json list = Json::array();
  const auto stored = survey.field->times();
  list.push_back({{"quantity", "smoke"},
                  {"source", survey.field->description()},
                  {"stored_times", stored.size()},
                  {"stored_from", stored.front()},
                  {"stored_until", stored.back()},
                  {"served_from", survey.times.front()},
                  {"served_until", survey.times.back()}});
  if (meter == nullptr)
    return list;
  for (const AirQuantity& one : airQuantities()) {
    for (const ServedSource& source : meter->air().sources(one.quantity)) {
      Json json = {{"quantity", one.name},         {"source", source.description},
                   {"stored_times", source.times}, {"stored_from", nullptr},
                   {"stored_until", nullptr},      {"served_from", nullptr},
                   {"served_until", nullptr}};
      if (source.times > 0) {
        json["stored_from"] = source.stored.from;
        json["stored_until"] = source.stored.until;
      }
      if (source.served) {
        json["served_from"] = source.served->from;
        json["served_until"] = source.served->until;
      }
      list.push_back(std::move(json));
    }
  }
  return list;
}

std::string sourcesTable(const Json& sources) {
  std::vector<HtmlRow> rows;
  for (const Json& one : sources) {
    const auto span = [&](const char* from, const char* until) {
      return one[from].is_null()
                 ? std::string("\u2013")
                 : htmlOf(one[from], "{:.4g}") + " to " + htmlOf(one[until], "{:.4g}");
    };
    const bool read = one["stored_times"] != 0;
    rows.push_back({htmlOf(one["quantity"]), htmlOf(one["source"]),
                    read ? htmlOf(one["stored_times"]) : "<b>not read</b>",
                    span("stored_from", "stored_until"), span("served_from", "served_until")});
  }
  return "<h2>Sources</h2>\n<p>Beyond the stored times nothing is known.</p>\n" +
         htmlTable({"quantity", "source", "stored times", "stored [s]", "used [s]"}, rows);
}

std::string assumedWords(const ExposureMeter& meter, std::size_t criterion) {
  const std::string assumed = listOf(meter.assumed(criterion));
  return assumed.empty() ? assumed
                         : fmt::format(" Not stored, counted as in clean air: {}.", assumed);
}

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
    if (!criterion.applies.empty())
      json["applies"] = criterion.applies;
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
    std::string source = (one.contains("applies") ? htmlOf(one["applies"]) + "; " : "") +
                         htmlOf(one["source_of_limit"]) +
                         (one["source_checked"] == true ? "" : " <b>(limit not checked)</b>");
    if (one.contains("model"))
      source += "; " + htmlOf(one["model"]["source"]);
    rows.push_back({htmlOf(one["name"]), htmlOf(one["criterion"]), from, source});
  }
  return "<h2>Criteria of tenability</h2>\n" +
         htmlTable({"name", "untenable when", "from", "source"}, rows);
}

PlanTenability::PlanTenability(const Survey& survey, AirField air, std::span<const Vec3> eyes,
                               const PlanUse& use, const PlanAreas& areas, PlanValues values,
                               std::vector<PlanShape> shapes, std::vector<SightTarget> signs)
    : survey_(&survey),
      eyes_(eyes),
      use_(use),
      people_(use.are(PlanUse::Kind::kPeople)),
      areas_(&areas),
      values_(values),
      shapes_(std::move(shapes)),
      signs_(std::move(signs)),
      meter_(std::move(air), survey.criteria, eyes.size(), true) {
  const std::vector<double> sizes = areas.sizes();
  for (const Criterion& criterion : meter_.criteria()) {
    std::vector<bool>& holds = holds_.emplace_back(eyes.size());
    for (std::size_t i = 0; i < holds.size(); ++i) holds[i] = criterion.isForRoom(sizes[i]);
    if (!criterion.law && criterion.quantity == Air::kExtinction)
      smoke_.push_back(holds_.size() - 1);
  }
  for (const Variation& one : variations()) {
    varied_.emplace_back();
    if (one.smoke != 1)
      addSmoke(one.smoke);
  }
}

/// Watches of what is reached if the smoke is so many times as thick.
void PlanTenability::addSmoke(double factor) {
  for (const std::size_t c : smoke_) {
    const Criterion& criterion = meter_.criteria()[c];
    varied_.back().emplace_back(eyes_.size(), criterion.limit / factor, criterion.falling);
  }
}

/// The places where people are for which a criterion is.
std::vector<bool> PlanTenability::countsOf(std::size_t criterion) const {
  std::vector<bool> counts = people_;
  for (std::size_t i = 0; i < counts.size(); ++i) counts[i] = counts[i] && holds_[criterion][i];
  return counts;
}

Status PlanTenability::take(const SurveyTime& at) {
  if (!at.stored)
    return {};
  // Where a door or a curtain stands now, nobody does.
  std::vector<double> smoke(at.extinctionHigh.begin(), at.extinctionHigh.end());
  free_.assign(eyes_.begin(), eyes_.end());
  for (std::size_t i = 0; i < smoke.size(); ++i) {
    if (at.extinctionLow[i] != SurveyTime::kSolid)
      continue;
    smoke[i] = SurveyTime::kSolid;
    free_[i].setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  for (auto& variation : varied_) {
    for (LevelWatch& watch : variation) watch.update(at.time, smoke);
  }
  return meter_.advance(
      at.time, [&](double, std::span<Vec3> places) { std::ranges::copy(free_, places.begin()); },
      {smoke, at.extinctionLow});
}

Status PlanTenability::goOn() {
  for (auto& variation : varied_) {
    for (LevelWatch& watch : variation) {
      for (std::size_t i = 0; i < eyes_.size(); ++i) watch.lose(i);
    }
  }
  meter_.loseSmoke();
  return meter_.advance(survey_->end, [&](double, std::span<Vec3> places) {
    std::ranges::copy(free_, places.begin());
  });
}

LossTimes PlanTenability::combined(const LossTimes& signs, const std::vector<bool>& inSight,
                                   const std::function<const LossTimes*(std::size_t)>& instead,
                                   std::vector<int>* which) const {
  std::vector<CountedLoss> all{{&signs, &inSight}};
  std::vector<int> of{0};
  for (std::size_t c = 0; c < meter_.criteria().size(); ++c) {
    if (!meter_.isAssessed(c))
      continue;
    const LossTimes* other = instead ? instead(c) : nullptr;
    all.push_back({other != nullptr ? other : &meter_.times(c), &holds_[c]});
    of.push_back(static_cast<int>(c) + 1);
  }
  LossTimes first = firstOf(all, survey_->round, which);
  if (which != nullptr) {
    for (int& one : *which) one = one < 0 ? one : of[static_cast<std::size_t>(one)];
  }
  return first;
}

LossTimes PlanTenability::latest(const Sight& sight) const {
  return combined(sight.latest, sight.in, [&](std::size_t c) { return meter_.latest(c); }, nullptr);
}

/// How the ASET of places where people are depends on what is not known well.
Result<std::string> PlanTenability::sensitivity(const Sight& sight, Json& report) const {
  const auto firstOf = [&](const LossTimes& times) {
    return firstLoss(times, RoundTime::kNone, people_);
  };
  const auto varied = [&](std::size_t v) {
    const auto watch = [&](std::size_t c) {
      const auto place = static_cast<std::size_t>(std::ranges::find(smoke_, c) - smoke_.begin());
      return place < varied_[v].size() ? &varied_[v][place].times() : nullptr;
    };
    return firstOf(combined(sight.varied[v], sight.in, watch, nullptr));
  };
  const auto at = [&](RoundTime round) {
    FirstLoss loss = firstLoss(all_, round, people_);
    loss.none = loss.by(round);
    return loss;
  };

  enum Place : std::size_t { kBrief, kLowC, kHighC, kThick, kThin, kMoreSoot, kLessSoot };

  const std::vector<Uncertainty> all{
      {"spacing of the stored times", "the one before", "the one after", at(RoundTime::kDown),
       at(RoundTime::kUp)},
      {"rounding, caps and means of files", "the thickest smoke", "the thinnest", firstOf(all_),
       firstOf(latest_)},
      {"brief losses between stored times", "within 2 % of a limit counts", "as stored",
       varied(kBrief), firstOf(all_)},
      {"C of the signs", "33 % lower", "33 % higher", varied(kLowC), varied(kHighC)},
      {"mass extinction, 8700 \u00b1 1100 m2/kg", "9800 m2/kg", "7600 m2/kg", varied(kThick),
       varied(kThin)},
      {"soot yield, 25 % assumed", "25 % larger", "25 % smaller", varied(kMoreSoot),
       varied(kLessSoot)}};
  report["sensitivity_of_aset"] = sensitivityJson(firstOf(all_), all);
  return sensitivityPart(report["sensitivity_of_aset"], survey_->times.front(), survey_->end,
                         survey_->folder / "tornado.png");
}

std::string PlanTenability::notAssessed() const {
  std::string names;
  for (const ExposureMeter::Missing& one : meter_.missing())
    names += (names.empty() ? "" : ", ") + one.criterion.name;
  for (std::size_t c = 0; c < meter_.criteria().size(); ++c) {
    if (!meter_.isAssessed(c)) {
      names += fmt::format("{}{} (not stored at this height)", names.empty() ? "" : ", ",
                           meter_.criteria()[c].name);
    }
  }
  return names;
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
  Json json = {{"points_without_data", unknown}};
  addTimes(json, "rows", times, survey_->round,
           [&](std::span<const Json> values) { return values_.rowsOfJson(values); });
  json["rows_interpolated"] = values_.rows(times.answers(RoundTime::kNone));
  json["rows_down"] = values_.rows(times.answers(RoundTime::kDown));
  json["rows_up"] = values_.rows(times.answers(RoundTime::kUp));
  if (const LossTimes* late = meter_.latest(c))
    json["rows_latest"] = values_.rows(late->answers(survey_->round));
  const bool dose = meter_.criteria()[c].isDose();
  json[dose ? "dose_at_the_end" : "worst_value"] = values_.rows(worst);
  if (const auto allowed = meter_.worstAllowed(c); !allowed.empty()) {
    for (std::size_t i = 0; i < eyes_.size(); ++i)
      worst[i] = meter_.unknown(c, i) ? kNoTime : allowed[i];
    json[dose ? "dose_at_most" : "worst_value_at_most"] = values_.rows(worst);
  }
  return json;
}

/// Where and when what a criterion takes in is stored: a time that is not known may lack a source
/// then, or one that reaches these places.
std::string PlanTenability::storedWords(std::size_t c) const {
  const Criterion& criterion = meter_.criteria()[c];
  std::string words;
  auto all = criterion.needed();
  const auto taken = criterion.taken();
  all.insert(all.end(), taken.begin(), taken.end());
  for (const Air one : all) {
    const std::string name(quantityOf(one).name);
    std::string spans;
    for (const ServedSource& source : meter_.air().sources(one)) {
      if (source.times == 0)
        continue;
      // "temperature (slice-temperature)"
      std::string from = source.description;
      if (from.starts_with(name + " (") && from.ends_with(')'))
        from = from.substr(name.size() + 2, from.size() - name.size() - 3);
      spans += fmt::format("{} from {} to {} s by {}{}", spans.empty() ? "" : ",",
                           plainNumber(source.stored.from, 4), plainNumber(source.stored.until, 4),
                           from, source.served ? "" : ", which reaches none of these places");
    }
    if (!spans.empty())
      words += fmt::format("{}{} is stored{}", words.empty() ? "" : "; ", name, spans);
  }
  if (const std::string unread = meter_.unread(c); !unread.empty())
    words +=
        fmt::format("{}not all that is stored can be read: {}", words.empty() ? "" : "; ", unread);
  return words.empty() ? words : " (" + words + ")";
}

namespace {

/// " (rooms of 100 m2 and more)" of one that is for rooms of a size.
std::string roomWords(const Criterion& criterion) {
  const double from = criterion.roomFrom, below = criterion.roomBelow;
  return from > 0 && !std::isinf(below) ? fmt::format(" (rooms of {:g} to {:g} m2)", from, below)
         : from > 0                     ? fmt::format(" (rooms of {:g} m2 and more)", from)
         : !std::isinf(below)           ? fmt::format(" (rooms below {:g} m2)", below)
                                        : "";
}

}  // namespace

Json PlanTenability::sentence(std::size_t c) const {
  const Criterion& criterion = meter_.criteria()[c];
  const std::vector<bool> counts = countsOf(c);
  const std::string words = criterion.words() + roomWords(criterion);
  const FirstLoss first = firstLoss(meter_.times(c), survey_->round, counts);
  const double end = survey_->end;
  std::string text;
  if (std::ranges::none_of(counts, std::identity())) {
    text = words + " applies nowhere: people are in no such room.";
  } else if (!first.certain()) {
    text = fmt::format("{} is {}{}", words, unknownWords(first, "reached", "the floor"),
                       storedWords(c));
    text += first.any ? fmt::format("; reached at the latest at {} s, at {}.",
                                    plainNumber(first.up, 4), placeWords(eyes_[first.place]))
                      : ".";
  } else {
    text = first.any
               ? fmt::format("{} is first reached at {}, at {}; by {} s at {} of the floor.", words,
                             timeWords(first, survey_->round), placeWords(eyes_[first.place]),
                             plainNumber(end), percentWords(first.share))
               : fmt::format("{} is not reached anywhere until {} s.", words, plainNumber(end));
    if (first.unknown > 0)
      text += fmt::format(" It is not known all along at {} of the floor{}.",
                          percentWords(first.unknown), storedWords(c));
  }
  Json latest;
  if (meter_.latest(c) != nullptr) {
    const FirstLoss late = firstLoss(*meter_.latest(c), survey_->round, counts);
    text += latestWords(first, late, "reached");
    latest = latestJson(late, survey_->round);
  }
  text += assumedWords(meter_, c);
  Json json = verdictJson(criterion.name, text, first, survey_->round, eyes_);
  if (meter_.latest(c) != nullptr)
    json["time_latest"] = std::move(latest);
  return json;
}

/// Criteria that leave the first of all open.
std::string PlanTenability::unknownReasons() const {
  std::string names;
  for (std::size_t c = 0; c < meter_.criteria().size(); ++c) {
    const FirstLoss one = firstLoss(meter_.times(c), survey_->round, countsOf(c));
    if (!one.certain() && meter_.isAssessed(c))
      names += fmt::format("{}{} ({})", names.empty() ? "" : ", ", meter_.criteria()[c].name,
                           std::isinf(one.known)
                               ? fmt::format("{} of the floor", percentWords(one.unknown))
                               : fmt::format("after {} s", plainNumber(one.known, 4)));
  }
  return names.empty() ? std::string(kSight) : names;
}

Json PlanTenability::headline(const std::vector<std::string>& names) const {
  const FirstLoss first = firstLoss(all_, survey_->round, people_);
  const double end = survey_->end;
  std::string text;
  if (!first.certain()) {
    text = fmt::format("ASET of all criteria: {}, because of {}",
                       unknownWords(first, "reached", "the floor"), unknownReasons());
    text += first.any
                ? fmt::format("; it is at the latest {} s, by {}, at {}.", plainNumber(first.up, 4),
                              names[first.place], placeWords(eyes_[first.place]))
                : ".";
  } else if (first.any) {
    text = fmt::format("ASET of all criteria: {}, by {}, at {}.", timeWords(first, survey_->round),
                       names[first.place], placeWords(eyes_[first.place]));
  } else {
    text = fmt::format("ASET of all criteria: none is reached until {} s.", plainNumber(end));
  }
  if (use_.fireUnknown && first.any)
    text += " Where it burns is not known: this may be the fire's own place.";
  constexpr double kMuch = 0.1;  // of the points: a burner alone is less
  const double burning =
      static_cast<double>(use_.count(PlanUse::Kind::kFire)) / static_cast<double>(eyes_.size());
  if (use_.fireFound || burning > kMuch) {
    const FirstLoss own = firstLoss(all_, survey_->round, use_.are(PlanUse::Kind::kFire));
    text +=
        fmt::format(" This leaves out {} of the points, {}: {}.", percentWords(burning),
                    use_.fireFound ? "taken for the fire's own place, which the case does not state"
                                   : "the fire's own place",
                    use_.firesFrom);
    const auto timeOf = [&](const FirstLoss& loss) {
      return loss.certain() ? loss.by(survey_->round) : loss.up;
    };
    if (own.any && !(first.any && timeOf(own) > timeOf(first))) {
      text += fmt::format(" With them it is {}{} s.", own.certain() ? "" : "at the latest ",
                          plainNumber(timeOf(own), 4));
    }
  }
  const FirstLoss late = firstLoss(latest_, survey_->round, people_);
  text += latestWords(first, late, "reached");
  if (const std::string missing = notAssessed(); !missing.empty())
    text += fmt::format(" Not assessed: {}.", missing);
  Json json = verdictJson("all", text, first, survey_->round, eyes_);
  json["time_latest"] = latestJson(late, survey_->round);
  if (first.any)
    json["by"] = names[first.place];
  json["not_assessed"] = Json::array();
  for (const ExposureMeter::Missing& one : meter_.missing())
    json["not_assessed"].push_back(one.criterion.name);
  for (std::size_t c = 0; c < meter_.criteria().size(); ++c) {
    if (!meter_.isAssessed(c))
      json["not_assessed"].push_back(meter_.criteria()[c].name);
  }
  return json;
}

/// What is said of the points that do not count.
Json PlanTenability::ofTheFire(const std::vector<std::string>& names) const {
  const auto burning = use_.are(PlanUse::Kind::kFire);
  const FirstLoss first = firstLoss(all_, survey_->round, burning);
  std::string text = fmt::format("The fire's own place ({}) is not counted", use_.firesFrom);
  text += first.any
              ? fmt::format("; there the first criterion, {}, is reached at {}{} s, at {}.",
                            names[first.place], first.certain() ? "" : "the latest at ",
                            plainNumber(first.certain() ? first.by(survey_->round) : first.up, 4),
                            placeWords(eyes_[first.place]))
              : ".";
  return verdictJson("the fire's own place", text, first, survey_->round, eyes_);
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
                                  const LossTimes& times, const std::vector<bool>& holds) const {
  PlanPicture picture = emptyPicture(title);
  picture.barLabel = "time [s]";
  picture.stored = true;
  picture.low = survey_->times.front();
  picture.high = std::max(survey_->end, picture.low + 1e-9);
  const std::vector<double>& by = times.by(survey_->round);
  for (std::size_t i = 0; i < eyes_.size(); ++i) {
    picture.values[values_.places[i]] = by[i];
    picture.marks[values_.places[i]] = !holds.empty() && !holds[i] ? PlanMark::kHidden
                                       : !times.complete(i)        ? PlanMark::kUnknown
                                       : std::isinf(by[i])         ? PlanMark::kKept
                                                                   : PlanMark::kValue;
  }
  picture.words = {{PlanMark::kHidden, "the criterion is not for rooms of this size"},
                   {PlanMark::kKept,
                    fmt::format("not reached at {} s, the last time", plainNumber(survey_->end))},
                   {PlanMark::kUnknown, kNotKnownWords},
                   {PlanMark::kSolid, kSolidWords}};
  return writePlan(survey_->folder / name, *values_.plan, picture, signs_);
}

Status PlanTenability::writeFirst() const {
  PlanPicture picture = emptyPicture(fmt::format("Which criterion is reached first, at z = {} m",
                                                 plainNumber(values_.plan->origin[2])));
  picture.kinds.emplace_back(kindColor(0), kSight);
  for (std::size_t c = 0; c < meter_.criteria().size(); ++c)
    picture.kinds.emplace_back(kindColor(c + 1), meter_.criteria()[c].name);
  for (std::size_t i = 0; i < eyes_.size(); ++i) {
    picture.values[values_.places[i]] = std::max(which_[i], 0);
    picture.marks[values_.places[i]] = !all_.complete(i) ? PlanMark::kUnknown
                                       : which_[i] >= 0  ? PlanMark::kValue
                                                         : PlanMark::kKept;
  }
  picture.words = {
      {PlanMark::kKept, fmt::format("none until {} s, the last time", plainNumber(survey_->end))},
      {PlanMark::kUnknown, kNotKnownWords},
      {PlanMark::kSolid, kSolidWords}};
  return writePlan(survey_->folder / "tenability_first.png", *values_.plan, picture, signs_);
}

Result<std::string> PlanTenability::margin(Json& report, std::vector<PlanArray>& arrays,
                                           Json& verdict) {
  if (!measuresMargins())
    return std::string();
  std::vector<double> rset(eyes_.size(), kNoTime);
  if (survey_->rset) {
    const double radius = std::max(survey_->step, 0.5);
    rset = survey_->rset->at(eyes_, radius);
    // What is required of the storey is required on its ramps, too, where eyes are higher.
    std::vector<Vec3> level(eyes_.begin(), eyes_.end());
    for (Vec3& eye : level) eye.z() = survey_->height;
    const std::vector<double> ofStorey = survey_->rset->at(level, radius);
    for (std::size_t i = 0; i < rset.size(); ++i) {
      rset[i] = std::fmax(rset[i], ofStorey[i]);
      if (!people_[i] && !survey_->rset->isOfPeople())
        rset[i] = kNoTime;
    }
  }
  for (const PlanAreas::Area& area : areas_->areas) {
    if (!area.rset)
      continue;
    for (const std::size_t i : area.eyes) rset[i] = people_[i] ? *area.rset : kNoTime;
  }
  const double end = survey_->end;
  margins_ = planMargins(std::move(rset), all_, survey_->round, end);
  std::vector<std::size_t> everywhere(eyes_.size());
  std::iota(everywhere.begin(), everywhere.end(), std::size_t{0});
  const auto [needed, tooLate, unknown, worst, open] = margins_.worst(everywhere);
  const std::string from = rsetDescription();
  report["rset"] = {{"from", from}, {"rows", values_.rows(margins_.rset)}};
  report["margin"] = {{"rows", values_.rows(margins_.margin)},
                      {"points_needed", needed},
                      {"points_too_late", tooLate},
                      {"points_not_known", unknown}};
  arrays.push_back({"rset", values_.cells(margins_.rset)});
  arrays.push_back({"margin", values_.cells(margins_.margin)});
  const auto share = [&, needed = needed](std::size_t points) {
    return percentWords(static_cast<double>(points) / static_cast<double>(needed));
  };
  std::string text;
  if (needed == 0) {
    text = fmt::format("RSET: no point of this plan is in use (RSET: {}).", from);
  } else if (unknown > 0) {
    const double least = margins_.least[*open];
    text = fmt::format(
        "ASET - RSET: not known at {} of the points in use, where people are still there after "
        "the time until which the air is known{}, at {}{} (RSET: {}).",
        share(unknown),
        std::isinf(least) ? std::string() : fmt::format(", by up to {} s", plainNumber(-least, 4)),
        placeWords(eyes_[*open]),
        tooLate > 0 ? fmt::format("; at {} of them people leave too late, by up to {} s",
                                  share(tooLate), plainNumber(-margins_.margin[*worst], 4))
                    : "",
        from);
  } else if (!worst || std::isinf(margins_.margin[*worst])) {
    text =
        fmt::format("ASET - RSET: no criterion is reached until {} s where people are (RSET: {}).",
                    plainNumber(end), from);
  } else {
    const double margin = margins_.margin[*worst], seconds = margins_.rset[*worst];
    const double low = all_.down[*worst] - seconds, high = all_.up[*worst] - seconds;
    text = fmt::format(
        "ASET - RSET: the smallest margin is {} s (by stored times {} to "
        "{} s) at {}; at {:.0f} % of the points in use, people leave too late "
        "(RSET: {}).",
        plainNumber(margin, 4), plainNumber(low, 4), plainNumber(high, 4),
        placeWords(eyes_[*worst]),
        100.0 * static_cast<double>(tooLate) / static_cast<double>(needed), from);
    const Vec3& place = eyes_[*worst];
    report["margin"]["least"] = Json{{"value", margin},
                                     {"down", low},
                                     {"up", high},
                                     {"position", {place[0], place[1], place[2]}}};
  }
  report["margin"]["known"] = unknown == 0;
  verdict.insert(verdict.begin() + 1,
                 Json{{"criterion", "margin"}, {"sentence", text}, {"known", unknown == 0}});
  std::vector<double> finite;
  for (const double one : margins_.margin) {
    if (std::isfinite(one))
      finite.push_back(one);
  }
  if (finite.empty())
    return std::string();
  PlanPicture picture =
      emptyPicture(fmt::format("ASET - RSET at z = {} m", plainNumber(values_.plan->origin[2])));
  picture.subtitle = from;
  picture.barLabel = "margin [s]";
  picture.low = *std::ranges::min_element(finite);
  picture.high = std::max(*std::ranges::max_element(finite), picture.low + 1);
  for (std::size_t i = 0; i < eyes_.size(); ++i) {
    const double one = margins_.margin[i];
    picture.values[values_.places[i]] = one;
    picture.marks[values_.places[i]] = std::isnan(margins_.rset[i]) ? PlanMark::kHidden
                                       : std::isnan(one)            ? PlanMark::kUnknown
                                       : std::isinf(one)            ? PlanMark::kKept
                                                                    : PlanMark::kValue;
  }
  picture.words = {{PlanMark::kKept, "no criterion is reached"},
                   {PlanMark::kHidden, "nobody comes here"},
                   {PlanMark::kUnknown, kNotKnownWords},
                   {PlanMark::kSolid, kSolidWords}};
  VOLUTE_TRY(writePlan(survey_->folder / "margin.png", *values_.plan, picture, signs_));
  return htmlFigure(survey_->folder / "margin.png",
                    "Margin: available minus required safe egress "
                    "time.");
}

bool PlanTenability::measuresMargins() const {
  return survey_->rset || std::ranges::any_of(areas_->areas, [](const PlanAreas::Area& area) {
           return area.rset.has_value();
         });
}

std::string PlanTenability::rsetDescription() const {
  std::string areas;
  for (const PlanAreas::Area& area : areas_->areas) {
    if (area.rset)
      areas += fmt::format("{}{} s in {}", areas.empty() ? "" : ", ", plainNumber(*area.rset),
                           area.name);
  }
  if (!survey_->rset)
    return areas;
  return survey_->rset->description() + (areas.empty() ? "" : ", but " + areas);
}

void PlanTenability::find(AreaFindings& found) const {
  found.all = &all_;
  found.latest = &latest_;
  found.by = names_;
  for (std::size_t c = 0; c < meter_.criteria().size(); ++c) {
    if (meter_.isAssessed(c))
      found.single.push_back(
          {meter_.criteria()[c].name, &meter_.times(c), holds_[c], meter_.latest(c)});
  }
  if (measuresMargins())
    found.margins = &margins_;
}

std::vector<std::size_t> PlanTenability::notKnown(const Sight& sight,
                                                  std::span<const std::size_t> eyes) const {
  const LossTimes all = combined(sight.earliest, sight.in, {}, nullptr);
  std::vector<std::size_t> some(eyes.begin(), eyes.end());
  constexpr double kNever = -std::numeric_limits<double>::infinity();
  std::erase_if(some, [&](std::size_t eye) { return all.known[eye] > kNever; });
  return some;
}

void PlanTenability::count(const PlanUse& use) {
  use_ = use;
  people_ = use.are(PlanUse::Kind::kPeople);
}

Result<PlanTenability::Parts> PlanTenability::finish(const Sight& sight, Json& report,
                                                     std::vector<PlanArray>& arrays,
                                                     Json& verdict) {
  all_ = combined(sight.earliest, sight.in, {}, &which_);
  latest_ = latest(sight);
  Json json = Json::object();
  json["criteria"] = criteriaJson(meter_);
  report["sources"] = sourcesJson(*survey_, &meter_);
  std::string criteria = volute::criteriaTable(meter_) + sourcesTable(report["sources"]);
  std::string figures;
  const auto asRows = [&](std::span<const Json> values) { return values_.rowsOfJson(values); };
  for (std::size_t c = 0; c < meter_.criteria().size(); ++c) {
    const Criterion& criterion = meter_.criteria()[c];
    const LossTimes& times = meter_.times(c);
    json["criteria"][c].update(criterionJson(c));
    verdict.push_back(sentence(c));
    const std::string name = Survey::fileName(criterion.name);
    std::vector<double> worst(meter_.worst(c).begin(), meter_.worst(c).end());
    for (std::size_t i = 0; i < worst.size(); ++i) {
      if (meter_.unknown(c, i))
        worst[i] = kNoTime;
    }
    arrays.push_back({"aset_" + name, values_.cells(times.answers(survey_->round))});
    if (const LossTimes* late = meter_.latest(c))
      arrays.push_back({"aset_latest_" + name, values_.cells(late->answers(survey_->round))});
    arrays.push_back({"known_until_" + name, values_.cells(knownUntil(times))});
    arrays.push_back({"worst_" + name, values_.cells(worst)});
    if (firstLoss(times, survey_->round, holds_[c]).certain() &&
        std::ranges::all_of(times.up, [](double time) { return std::isinf(time); }))
      continue;
    const std::string file = "tenability_" + name + ".png";
    VOLUTE_TRY(writeTimes(
        file,
        fmt::format("When {} at z = {} m", criterion.words(), plainNumber(values_.plan->origin[2])),
        times, holds_[c]));
    VOLUTE_ASSIGN(const auto figure, htmlFigure(survey_->folder / file, criterion.words()));
    figures += figure;
  }
  std::vector<std::string>& names = names_;
  names.assign(eyes_.size(), "");
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (which_[i] >= 0)
      names[i] =
          which_[i] == 0 ? kSight : meter_.criteria()[static_cast<std::size_t>(which_[i]) - 1].name;
  }
  json["aset"] = Json::object();
  addTimes(json["aset"], "rows", all_, survey_->round, asRows);
  json["aset"]["rows_interpolated"] = values_.rows(all_.answers(RoundTime::kNone));
  json["aset"]["rows_down"] = values_.rows(all_.answers(RoundTime::kDown));
  json["aset"]["rows_up"] = values_.rows(all_.answers(RoundTime::kUp));
  json["aset"]["rows_latest"] = values_.rows(latest_.answers(survey_->round));
  json["aset"]["rows_of_the_first_criterion"] = values_.rowsOfText(names);
  arrays.push_back({"aset_all", values_.cells(all_.answers(survey_->round))});
  arrays.push_back({"aset_latest_all", values_.cells(latest_.answers(survey_->round))});
  arrays.push_back({"known_until_all", values_.cells(knownUntil(all_))});
  verdict.insert(verdict.begin(), headline(names));
  if (use_.count(PlanUse::Kind::kFire) > 0)
    verdict.push_back(ofTheFire(names));
  VOLUTE_TRY(writeTimes(
      "aset_all.png",
      fmt::format("ASET of all criteria at z = {} m", plainNumber(values_.plan->origin[2])), all_));
  VOLUTE_TRY(writeFirst());
  VOLUTE_ASSIGN(const auto times, htmlFigure(survey_->folder / "aset_all.png",
                                             "When the first of all criteria is reached."));
  VOLUTE_ASSIGN(const auto kinds, htmlFigure(survey_->folder / "tenability_first.png",
                                             "Which criterion is reached first."));
  VOLUTE_ASSIGN(const auto left, margin(json, arrays, verdict));
  report["tenability"] = std::move(json);
  VOLUTE_ASSIGN(const auto sensible, sensitivity(sight, report));
  return Parts{std::move(criteria), "<h2>Tenability</h2>\n" + times + kinds + left + figures,
               sensible};
}

}  // namespace volute
