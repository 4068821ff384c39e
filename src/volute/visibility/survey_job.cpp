// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/survey_job.hpp"

#include <algorithm>

#include "volute/base/output_folder.hpp"
#include "volute/base/remark_log.hpp"
#include "volute/base/write_file.hpp"
#include "volute/visibility/sight_csv.hpp"
#include "volute/visibility/survey_page.hpp"

namespace volute {
namespace {

constexpr const char* kMark = "visibility.json";
constexpr std::uint64_t kMostLines = std::uint64_t{512} << 20;  // bytes of worked-out sight lines

Result<std::vector<SignSet>> setsOf(const SurveyRequest& request) {
  std::vector<SignSet> sets{{"all signs", {}}};
  for (std::size_t s = 0; s < request.signs.size(); ++s) sets[0].members.push_back(s);
  if (request.signs.size() > 1) {
    for (std::size_t s = 0; s < request.signs.size(); ++s)
      sets.push_back({request.signs[s].name, {s}});
  }
  for (const auto& names : request.sets) {
    SignSet set{fmt::format("{}", fmt::join(names, ", ")), {}};
    for (const std::string& name : names) {
      const auto found = std::ranges::find(request.signs, name, &SafetySign::name);
      if (found == request.signs.end())
        return fail(ErrorCode::kInvalidArgument, "--set: no sign is named '{}'", name);
      set.members.push_back(static_cast<std::size_t>(found - request.signs.begin()));
    }
    sets.push_back(std::move(set));
  }
  return sets;
}

/// Places in the stored times, by their numbers.
Result<std::vector<int>> chosenTimes(const FrameRange& range, const SightField& field) {
  VolumeInfo info;
  info.frames = static_cast<int>(field.times().size());
  for (int i = 0; i < info.frames; ++i)
    info.frameNumbers.push_back(field.numberOf(static_cast<std::size_t>(i)));
  return selectPositions(info, range);
}

Json signJson(const SightTarget& target) {
  const SafetySign& sign = target.sign;
  const auto vector = [](const Vec3& v) { return Json{v[0], v[1], v[2]}; };
  Json json = {
      {"name", sign.name},
      {"position", vector(sign.position)},
      {"normal", vector(sign.normal)},
      {"law", sign.law.name},
      {"C", sign.law.c},
      {"source", sign.law.source.empty() ? "stated with the sign" : std::string(sign.law.source)},
      {"source_checked", sign.law.checked},
      {"angle_law", nameOf(sign.angle)}};
  if (sign.size[0] > 0)
    json["size"] = {sign.size[0], sign.size[1]};
  if (target.target != sign.position)
    json["sight_lines_end_at"] = vector(target.target);
  return json;
}

/// Shares of the eyes at one time, and how many cannot be told for sure.
Json summaryOf(const SurveyTime& at, const Survey& survey) {
  const std::size_t eyes = at.eyes.size();
  const double unit = eyes > 0 ? 1.0 / static_cast<double>(eyes) : 0;
  std::size_t any = 0, uncertain = 0, uncovered = 0;
  std::vector<std::size_t> bySign(survey.signs.size());
  for (std::size_t i = 0; i < eyes; ++i) {
    bool seen = false;
    for (std::size_t s = 0; s < survey.signs.size(); ++s) {
      const Sighting& sighting = at.sightings[s * eyes + i];
      seen |= sighting.visible;
      bySign[s] += sighting.visible;
      uncertain += sighting.possibly != sighting.certainly;
      uncovered += !sighting.covered;
    }
    any += seen;
  }
  Json signs = Json::object();
  for (std::size_t s = 0; s < survey.signs.size(); ++s)
    signs[survey.signs[s].sign.name] = unit * static_cast<double>(bySign[s]);
  return {{"time", at.time}, {"eyes", eyes},           {"any", unit * static_cast<double>(any)},
          {"signs", signs},  {"uncertain", uncertain}, {"uncovered", uncovered}};
}

/// The survey as it goes through time.
class Job {
 public:
  Job(SurveyRequest request, SightField& field, Watch& watch, SurveyPictures& pictures,
      Progress& progress)
      : request_(std::move(request)),
        field_(field),
        watch_(watch),
        pictures_(pictures),
        log_(progress),
        lookout_(std::min(request_.maxMemory / 4, kMostLines)),
        survey_(request_.survey) {}

  Result<SurveySummary> run() {
    VOLUTE_ASSIGN(survey_.sets, setsOf(request_));
    VOLUTE_ASSIGN(const auto chosen, chosenTimes(request_.frames, field_));
    for (const int i : chosen) survey_.times.push_back(field_.times()[i]);
    survey_.bounds = field_.bounds();
    for (const std::string& remark : field_.remarks()) log_.remark(remark);
    for (const std::string& remark : request_.remarks) log_.remark(remark);
    VOLUTE_ASSIGN(auto folder, PendingFolder::create(request_.output, kMark));
    survey_.folder = folder.path();
    VOLUTE_ASSIGN(auto csv, SightCsv::create(folder.path() / "sight.csv"));
    for (std::size_t i = 0; i < chosen.size(); ++i) {
      if (log_.cancelled())
        return fail(ErrorCode::kCancelled, "stopped at {} s; nothing was written",
                    survey_.times[i]);
      VOLUTE_TRY(takeTime(static_cast<std::size_t>(chosen[i]), survey_.times[i], csv));
      log_.report("looking", static_cast<double>(i + 1), static_cast<double>(chosen.size()));
    }
    VOLUTE_TRY(csv.finish());
    remarkOnUncovered();
    VOLUTE_TRY(finish(folder));
    return SurveySummary{csv.rows(), survey_.times, summary_.front()["any"].get<double>(),
                         summary_.back()["any"].get<double>()};
  }

 private:
  Status takeTime(std::size_t index, double time, SightCsv& csv) {
    VOLUTE_ASSIGN(const auto instant, field_.read(index));
    if (survey_.signs.empty()) {
      VOLUTE_ASSIGN(survey_.signs, placeSigns(*instant, request_.signs, survey_.bounds, log_));
      VOLUTE_TRY(watch_.begin(survey_, *instant, log_));
      VOLUTE_TRY(pictures_.begin(survey_, *instant));
    }
    const auto eyes = watch_.eyes(time);
    const std::uint64_t lines = eyes.size() * survey_.signs.size();
    if (lines > request_.maxMemory / (2 * sizeof(Sighting))) {
      return fail(ErrorCode::kTooLarge,
                  "{} eyes and {} signs are more sight lines than fit in --max-memory; expected at "
                  "most {}: choose a larger --step or fewer signs",
                  eyes.size(), survey_.signs.size(), request_.maxMemory / (2 * sizeof(Sighting)));
    }
    sightings_.resize(lines);
    lookout_.look(*instant, survey_.signs, eyes, sightings_, survey_.times.size() > 1);
    const SurveyTime at{time, *instant, eyes, sightings_};
    VOLUTE_TRY(csv.write(time, eyes, survey_.signs, sightings_));
    summary_.push_back(summaryOf(at, survey_));
    return watch_.take(at);
  }

  void remarkOnUncovered() {
    std::size_t uncovered = 0, all = 0;
    for (const Json& record : summary_) {
      uncovered += record["uncovered"].get<std::size_t>();
      all += record["eyes"].get<std::size_t>() * survey_.signs.size();
    }
    if (uncovered > 0) {
      log_.remark(
          fmt::format("{} of {} sight lines run through places of which the case stores no smoke: "
                      "they count as "
                      "not seen, and their optical depth is nan",
                      uncovered, all));
    }
  }

  Status finish(PendingFolder& folder) {
    json_ = {{"format", "volute-visibility-1"},
             {"case", request_.casePath},
             {"smoke", field_.description()},
             {"criterion",
              "seen when nothing opaque stands between and the optical depth (integral "
              "of K ds, natural logarithm) is at most C times the angle law's factor"}};
    json_["signs"] = Json::array();
    for (const SightTarget& target : survey_.signs) json_["signs"].push_back(signJson(target));
    json_["times"] = survey_.times;
    json_["summary"] = summary_;
    VOLUTE_ASSIGN(auto body, watch_.finish(json_));
    VOLUTE_ASSIGN(const auto views, pictures_.finish(survey_, json_));
    body += views;
    json_["remarks"] = log_.remarks();
    if (watch_.hasPage())
      VOLUTE_TRY(writeSurveyPage(folder.path() / "report.html", json_, body));
    VOLUTE_TRY(writeFile(folder.path() / kMark, dumpJson(json_) + "\n"));
    return folder.commit();
  }

  SurveyRequest request_;
  SightField& field_;
  Watch& watch_;
  SurveyPictures& pictures_;
  RemarkLog log_;
  Lookout lookout_;
  Survey survey_;
  std::vector<Sighting> sightings_;
  Json summary_ = Json::array();
  Json json_;
};

}  // namespace

Result<SurveySummary> runSurvey(SurveyRequest request, SightField& field, Watch& watch,
                                SurveyPictures& pictures, Progress& progress) {
  return Job(std::move(request), field, watch, pictures, progress).run();
}

}  // namespace volute
