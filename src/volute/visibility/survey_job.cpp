// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/survey_job.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "volute/base/gather_values.hpp"
#include "volute/base/ordered_delivery.hpp"
#include "volute/base/output_folder.hpp"
#include "volute/base/parallel.hpp"
#include "volute/base/plain_number.hpp"
#include "volute/base/remark_log.hpp"
#include "volute/base/version.hpp"
#include "volute/base/write_file.hpp"
#include "volute/report/csv_cell.hpp"
#include "volute/report/pdf.hpp"
#include "volute/report/sha256.hpp"
#include "volute/visibility/sight_csv.hpp"
#include "volute/visibility/survey_page.hpp"

namespace volute {
namespace {

constexpr const char* kMark = "visibility.json";
constexpr std::uint64_t kMaxLines = std::uint64_t{512} << 20;  // bytes of worked-out sight lines

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
        return failFor("set", ErrorCode::kInvalidArgument, "no sign is named '{}'", name);
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
      Progress& progress, Team& team)
      : request_(std::move(request)),
        field_(field),
        watch_(watch),
        pictures_(pictures),
        log_(progress),
        team_(team),
        lookout_(std::min(request_.maxMemory / 4, kMaxLines)),
        rowMaker_(request_.sightFile),
        survey_(request_.survey) {}

  Result<SurveySummary> run() {
    VOLUTE_ASSIGN(survey_.sets, setsOf(request_));
    VOLUTE_ASSIGN(chosen_, chosenTimes(request_.frames, field_));
    for (const int i : chosen_) survey_.times.push_back(field_.times()[i]);
    survey_.end = survey_.times.back();
    survey_.bounds = field_.bounds();
    survey_.north = field_.north();
    survey_.field = &field_;
    survey_.maxMemory = request_.maxMemory;
    // Rows are made, then handed over with the sightings; other ranks' lines wait here.
    const bool text = request_.sightFile == SightFile::kCsv;
    survey_.bytesOfLine = (team_.size() > 1 ? 2 : 1) * sizeof(Sighting) +
                          (text ? 2 : 1) * bytesOfRow(SightRowMaker::kManyRows);
    if (watch_.wantsChanges())
      changes_ = field_.changes();
    if (survey_.times.size() + changes_.size() > SignLoss::kMaxTimes) {
      return fail(ErrorCode::kTooLarge,
                  "{} stored times, and {} at which something opaque comes or goes: expected at "
                  "most {} together: take fewer frames",
                  survey_.times.size(), changes_.size(), SignLoss::kMaxTimes);
    }
    for (const Remark& remark : field_.remarks()) log_.remark(remark);
    for (const Remark& remark : request_.remarks) log_.remark(remark);
    VOLUTE_TRY(team_.agree(openFolder()));
    VOLUTE_TRY(shareFolder());
    VOLUTE_TRY(begin());
    const auto units = static_cast<std::int64_t>(chosen_.size());
    OrderedDelivery seen(team_, units, request_.maxMemory / 8,
                         [&](std::int64_t i, const Bytes& bytes) { return take(i, bytes); });
    VOLUTE_TRY(team_.forUnits(
        "looking", units, log_,
        [&](std::int64_t i) -> Status {
          VOLUTE_ASSIGN(auto bytes, look(static_cast<std::size_t>(i)));
          return seen.give(i, std::move(bytes));
        },
        [&] { return seen.finish(); }));
    VOLUTE_TRY(remarkOnAll());
    VOLUTE_TRY(team_.agree(team_.leads() ? finish() : Status()));
    SurveySummary summary{0, survey_.times, 0, 0, {}};
    if (team_.leads()) {
      summary.sightLines = csv_->rows();
      const auto share = [](const Json& record) {
        return record["eyes"] == 0 ? std::numeric_limits<double>::quiet_NaN()
                                   : record["any"].get<double>();
      };
      summary.seenFirst = share(summary_.front());
      summary.seenLast = share(summary_.back());
      for (const Json& one : page_.report.value("verdict", Json::array()))
        summary.verdict.push_back(one["sentence"].get<std::string>());
      if (watch_.hasPage())
        summary.page = std::move(page_);
    }
    return summary;
  }

 private:
  using Bytes = OrderedDelivery::Bytes;

  /// What a rank sends of a time: this, the sightings, extinction at the eyes, its upper and lower
  /// bounds there, upper ones at places that are passed, and rows of the table, each at a multiple
  /// of eight bytes.
  struct Lengths {
    double time = 0;
    bool stored = false, packed = false;
    std::uint64_t sightings = 0, extinction = 0, passed = 0, text = 0, rows = 0;
  };

  static constexpr std::size_t paddedSize(std::size_t bytes) { return (bytes + 7) / 8 * 8; }

  static_assert(sizeof(Lengths) % 8 == 0 && sizeof(Sighting) == 48);

  /// On the largest extinction of all ranks' times.
  Status remarkOnAll() {
    const double own = field_.largestRead().value_or(-1);
    VOLUTE_ASSIGN(const auto each, gatherValues(team_, std::span(&own, 1)));
    const double largest = std::ranges::max(each);
    const bool all = chosen_.size() == field_.times().size();
    if (!team_.leads() || largest < 0 || (largest == 0 && !all))
      return {};
    for (const Remark& remark : field_.remarksOn(largest)) log_.remark(remark);
    return {};
  }

  Status openFolder() {
    if (!team_.leads())
      return {};
    VOLUTE_ASSIGN(auto folder, PendingFolder::create(request_.output, kMark));
    folder_.emplace(std::move(folder));
    VOLUTE_ASSIGN(auto csv, SightCsv::create(folder_->path(), request_.sightFile));
    csv_.emplace(std::move(csv));
    return {};
  }

  Status shareFolder() {
    const std::string own = team_.leads() ? folder_->path().string() : std::string();
    VOLUTE_ASSIGN(const auto all, team_.gatherTexts(own));
    survey_.folder = all.front();
    if (team_.leads())
      survey_.parts = std::make_shared<JsonParts>(survey_.folder);
    return {};
  }

  /// With the first time's smoke, on each rank.
  Status begin() {
    VOLUTE_ASSIGN(first_, field_.read(static_cast<std::size_t>(chosen_[0])));
    VOLUTE_ASSIGN(survey_.signs, placeSigns(*first_, request_.signs, survey_.bounds, log_));
    VOLUTE_TRY(watch_.begin(survey_, *first_, log_));
    remarkOnBeyond();
    findEnd();
    if (team_.leads())
      VOLUTE_TRY(pictures_.begin(survey_, *first_));
    if (looksAgain())
      VOLUTE_TRY(lookout_.workOutTogether(*first_, survey_.signs,
                                          watch_.eyes(survey_.times.front()), team_));
    return {};
  }

  /// On ends of sight lines beyond all smoke, where the field says that the air is clear.
  void remarkOnBeyond() {
    if (!team_.leads() || !field_.clearBeyond())
      return;
    const Box3& box = survey_.bounds;
    const auto isBeyond = [&](const Vec3& point) { return !box.contains(point); };
    const std::vector<Vec3> eyes = watch_.eyes(survey_.times.front());
    const auto eyesBeyond = std::ranges::count_if(eyes, isBeyond);
    const auto signsBeyond = std::ranges::count_if(survey_.signs, isBeyond, &SightTarget::target);
    if (eyesBeyond + signsBeyond == 0)
      return;
    log_.remark({RemarkCode::kAssumed,
                 fmt::format("{} of {} eyes and {} of {} signs are beyond the bounds of the smoke, "
                             "{} .. {}, {} .. {}, {} .. {} m: the air there "
                             "counts as clear",
                             eyesBeyond, eyes.size(), signsBeyond, survey_.signs.size(),
                             plainNumber(box.min[0], 4), plainNumber(box.max[0], 4),
                             plainNumber(box.min[1], 4), plainNumber(box.max[1], 4),
                             plainNumber(box.min[2], 4), plainNumber(box.max[2], 4))});
  }

  /// Until when the case goes on, if that is more than a stored time beyond the smoke.
  void findEnd() {
    const auto stored = field_.times();
    const std::size_t last = stored.size() - 1;
    if (static_cast<std::size_t>(chosen_.back()) != last)
      return;  // somebody wants to know no more
    const double end = std::max(field_.end(), watch_.end());
    const double interval = last > 0 ? stored[last] - stored[last - 1] : 0;
    if (!(end - stored[last] > (1 + 1e-6) * interval))
      return;
    survey_.end = end;
    log_.remark({RemarkCode::kDoubtful,
                 fmt::format("the smoke is stored until {} s, and the case goes on until {} s: "
                             "what is lost since then is not known",
                             plainNumber(stored[last]), plainNumber(end))});
  }

  /// Whether the same sight lines are looked along more than once.
  bool looksAgain() const { return survey_.times.size() > 1 && !watch_.moves(); }

  Result<std::shared_ptr<const SightSnapshot>> snapshotAt(std::size_t i) {
    if (auto first = std::exchange(first_, nullptr); first && i == 0)
      return first;
    return field_.read(static_cast<std::size_t>(chosen_[i]));
  }

  /// All of a stored time that can be said without the others, and of what changed since the one
  /// before.
  Result<Bytes> look(std::size_t i) {
    if (log_.cancelled())
      return fail(ErrorCode::kCancelled, "stopped at {} s; nothing was written", survey_.times[i]);
    Bytes bytes;
    if (i > 0)
      VOLUTE_TRY(lookAtChanges(survey_.times[i - 1], survey_.times[i], bytes));
    VOLUTE_ASSIGN(const auto snapshot, snapshotAt(i));
    VOLUTE_TRY(lookAt(*snapshot, i, survey_.times[i], true, bytes));
    return bytes;
  }

  /// What opaque things that come or go between two stored times do: what was there until then, and
  /// what is there from then on.
  Status lookAtChanges(double from, double to, Bytes& bytes) {
    for (const double change : changes_) {
      if (!(change > from && change <= to))
        continue;
      for (const double time : {std::nextafter(change, from), change}) {
        if (time == to)
          continue;  // the stored time
        VOLUTE_ASSIGN(const auto snapshot, field_.readAt(time));
        VOLUTE_TRY(lookAt(*snapshot, 0, change, false, bytes));
      }
    }
    return {};
  }

  Status lookAt(const SightSnapshot& snapshot, std::size_t index, double time, bool stored,
                Bytes& bytes) {
    const auto eyes = watch_.eyes(time);
    const std::uint64_t lines = eyes.size() * survey_.signs.size();
    constexpr std::uint64_t kEye = 640;  // itself, what is asked of its place, rows of tables
    VOLUTE_TRY(survey_.checkMemory(eyes.size(), kEye));
    const bool smoke =
        survey_.extinctionLimit > 0 || !survey_.criteria.empty() || watch_.wantsExtinction();
    const std::size_t points = smoke ? eyes.size() : 0;
    const auto passed = stored && smoke ? watch_.passed(time) : std::vector<Vec3>();
    // All is worked out where it is handed over, as there may be millions of lines.
    const std::size_t start = bytes.size();
    const std::size_t size = sizeof(Lengths) + lines * sizeof(Sighting) +
                             (3 * points + 2 * passed.size()) * sizeof(double);
    bytes.reserve(start + size + (stored ? lines * bytesOfRow(lines) : 0));
    bytes.resize(start + size);
    auto* const firstSighting = reinterpret_cast<Sighting*>(bytes.data() + start + sizeof(Lengths));
    std::uninitialized_value_construct_n(firstSighting, lines);
    const std::span sightings(firstSighting, lines);
    const std::span extinction(reinterpret_cast<double*>(firstSighting + lines), points);
    const std::span high(extinction.data() + points, points);
    const std::span low(high.data() + points, points);
    const std::span passedHigh(low.data() + points, passed.size());
    const std::span passedLow(passedHigh.data() + passed.size(), passed.size());
    lookout_.look(snapshot, survey_.signs, eyes, sightings, looksAgain());
    parallelRanges(extinction.size(), 512, [&](std::size_t begin, std::size_t end) {
      const auto part = [&](auto all) { return std::span(all).subspan(begin, end - begin); };
      snapshot.extinctionBounds(part(eyes), part(low), part(high));
      for (std::size_t i = begin; i < end; ++i) {
        Place place{};
        if (std::isnan(low[i]))
          snapshot.places({&eyes[i], 1}, {&place, 1});
        if (place == Place::kSolid)
          low[i] = SurveyTime::kSolid;
      }
      const auto sameOrNot = [](double a, double b) {
        return a == b || (std::isnan(a) && std::isnan(b));
      };
      if (std::ranges::equal(part(low), part(high), sameOrNot))
        std::ranges::copy(part(low), part(extinction).begin());
      else
        snapshot.extinction(part(eyes), part(extinction));
    });
    parallelRanges(passed.size(), 512, [&](std::size_t begin, std::size_t end) {
      snapshot.extinctionBounds(std::span(passed).subspan(begin, end - begin),
                                passedLow.subspan(begin, end - begin),
                                passedHigh.subspan(begin, end - begin));
    });
    SightRows rows;
    if (stored) {
      // Writing maps waits for the disk; the rows are made meanwhile.
      Status drawn;
      Result<SightRows> made;
      parallelFor(2, [&](std::size_t what) {
        if (what == 0)
          drawn = watch_.draw({index, time, eyes, sightings, extinction, high, low}, snapshot);
        else
          made = rowMaker_.make(time, eyes, survey_.signs, sightings);
      });
      VOLUTE_TRY(drawn);
      VOLUTE_ASSIGN(rows, std::move(made));
    }
    const Lengths lengths{time,   stored,        rows.packed,   lines,
                          points, passed.size(), rows.textSize, rows.bytes.size()};
    std::memcpy(bytes.data() + start, &lengths, sizeof lengths);
    rows.bytes.resize(paddedSize(rows.bytes.size()));
    const auto text = std::as_bytes(std::span(rows.bytes));
    bytes.insert(bytes.end(), text.begin(), text.end());
    return {};
  }

  /// What a row of the table takes, more or less, of so many at a time.
  std::uint64_t bytesOfRow(std::uint64_t rows) const {
    constexpr std::uint64_t kText = 160, kPacked = 40;
    if (request_.sightFile == SightFile::kNone)
      return 0;
    return request_.sightFile == SightFile::kCsv || rows < SightRowMaker::kManyRows ? kText
                                                                                    : kPacked;
  }

  /// What look() gave, in the order of times, on rank 0.
  Status take(std::int64_t i, const Bytes& bytes) {
    const std::byte* at = bytes.data();
    while (at != bytes.data() + bytes.size()) {
      const auto& lengths = *reinterpret_cast<const Lengths*>(at);
      const std::span sightings(reinterpret_cast<const Sighting*>(at + sizeof lengths),
                                lengths.sightings);
      const std::span extinction(
          reinterpret_cast<const double*>(sightings.data() + sightings.size()), lengths.extinction);
      const std::span high(extinction.data() + extinction.size(), lengths.extinction);
      const std::span low(high.data() + high.size(), lengths.extinction);
      const std::span passed(low.data() + low.size(), lengths.passed);
      const std::span passedLow(passed.data() + passed.size(), lengths.passed);
      const auto* text = reinterpret_cast<const char*>(passedLow.data() + passedLow.size());
      at = reinterpret_cast<const std::byte*>(text) + paddedSize(lengths.rows);
      const auto eyes = watch_.eyes(lengths.time);
      const SurveyTime seen{static_cast<std::size_t>(i),
                            lengths.time,
                            eyes,
                            sightings,
                            extinction,
                            high,
                            low,
                            passed,
                            passedLow,
                            lengths.stored};
      if (lengths.stored) {
        VOLUTE_TRY(csv_->write(
            {lengths.sightings, lengths.packed, lengths.text, std::string(text, lengths.rows)}));
        summary_.push_back(summaryOf(seen, survey_));
      }
      VOLUTE_TRY(watch_.take(seen));
    }
    return {};
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

  Status finish() {
    VOLUTE_ASSIGN(const auto sightFile, csv_->finish());
    remarkOnUncovered();
    page_.report = {{"format", "volute-visibility-1"},
                    {"case", request_.casePath},
                    {"smoke", field_.description()},
                    {"criterion",
                     "seen when nothing opaque stands between and the optical depth (integral "
                     "of K ds, natural logarithm) is at most C times the angle law's factor"},
                    {"sight_file", sightFile.empty() ? Json() : Json(sightFile)}};
    addFacts();
    if (!request_.profile.criteria.empty()) {
      page_.report["criteria_profile"] = {{"name", request_.profile.name},
                                          {"title", request_.profile.title},
                                          {"source", request_.profile.citation},
                                          {"applies", request_.profile.applies}};
    }
    VOLUTE_ASSIGN(page_.report["document"], documentJson());
    page_.report["signs"] = Json::array();
    for (const SightTarget& target : survey_.signs)
      page_.report["signs"].push_back(signJson(target));
    page_.report["times"] = survey_.times;
    page_.report["end"] = survey_.end;
    page_.report["round"] = nameOf(survey_.round);
    page_.report["summary"] = summary_;
    VOLUTE_ASSIGN(page_.body, watch_.finish(page_.report));
    VOLUTE_ASSIGN(const auto views, pictures_.finish(survey_, page_.report));
    page_.body += views;
    page_.report["remarks"] = log_.sentences();
    if (watch_.hasPage()) {
      VOLUTE_TRY(writeSurveyPage(folder_->path() / "report.html", page_));
      if (request_.pdf) {
        const auto printed =
            printPdf(folder_->path() / "report.html", folder_->path() / "report.pdf");
        if (!printed) {
          log_.remark({RemarkCode::kLeftOut, printed.error().message});
          page_.report["remarks"] = log_.sentences();
        }
      }
    }
    VOLUTE_TRY(survey_.parts->write(folder_->path() / kMark, page_.report));
    if (watch_.hasPage())
      VOLUTE_TRY(writeFile(folder_->path() / "curves.csv", curvesCsv()));
    survey_.parts.reset();
    return folder_->commit();
  }

  /// What the page draws over time, a row a point.
  std::string curvesCsv() const {
    std::string text = "figure,name,unit,time,value\n";
    const auto add = [&](const char* figure, const std::string& name, const std::string& unit,
                         const Json& time, const Json& value) {
      text += fmt::format("{},{},{},{},{}\n", figure, csvCell(name), csvCell(unit), time.dump(),
                          value.is_number() ? value.dump() : "");
    };
    for (const auto& [figure, key] :
         {std::pair("heat release", "fire"), std::pair("devices", "devices")}) {
      if (!page_.report.contains(key))
        continue;
      for (const Json& curve : page_.report[key]) {
        const Json& times = curve["times"];
        for (std::size_t i = 0; i < std::min(times.size(), curve["values"].size()); ++i)
          add(figure, curve["name"], curve["unit"], times[i], curve["values"][i]);
      }
    }
    for (const Json& record : summary_) {
      add("share of the eyes that see a sign", "any sign", "1", record["time"], record["any"]);
      for (const auto& [sign, share] : record["signs"].items())
        add("share of the eyes that see a sign", sign, "1", record["time"], share);
    }
    return text;
  }

  /// What a signed report says of itself; null where it is not stated.
  Result<Json> documentJson() {
    const auto& [name, project, author, date, inputs] = request_.document;
    const auto stated = [](const std::string& text) { return text.empty() ? Json() : Json(text); };
    Json json = {
        {"title", stated(name)}, {"project", stated(project)},          {"author", stated(author)},
        {"date", stated(date)},  {"program", "Volute " VOLUTE_VERSION}, {"inputs", Json::array()}};
    for (const std::filesystem::path& input : inputs) {
      constexpr std::uint64_t kMax = 256 << 20;  // a second
      std::error_code error;
      const auto bytes = std::filesystem::file_size(input, error);
      if (error)
        continue;  // a folder
      std::string sum;
      if (bytes <= kMax) {
        VOLUTE_ASSIGN(sum, sha256Of(input));
      }
      json["inputs"].push_back(
          {{"file", input.string()}, {"bytes", bytes}, {"sha256", stated(sum)}});
    }
    return json;
  }

  /// Title block and curves of the case.
  void addFacts() {
    auto facts = field_.facts();
    if (!facts) {
      log_.remark({RemarkCode::kLeftOut, facts.error().message});
      return;
    }
    for (const std::string& remark : facts->remarks) log_.remark({RemarkCode::kLeftOut, remark});
    Json& title = page_.report["title_block"] = Json::object();
    for (const auto& [name, value] : facts->title) title[name] = value;
    title["analysis"] = "Volute " VOLUTE_VERSION;
    if (!request_.document.author.empty())
      title["by"] = request_.document.author;
    if (!request_.document.date.empty())
      title["date"] = request_.document.date;
    const auto curves = [](const std::vector<FactCurve>& from) {
      Json list = Json::array();
      for (const FactCurve& curve : from)
        list.push_back({{"name", curve.name},
                        {"unit", curve.unit},
                        {"times", curve.times},
                        {"values", curve.values}});
      return list;
    };
    page_.report["fire"] = curves(facts->fire);
    page_.report["devices"] = curves(facts->devices);
  }

  SurveyRequest request_;
  SightField& field_;
  Watch& watch_;
  SurveyPictures& pictures_;
  RemarkLog log_;
  Team& team_;
  Lookout lookout_;
  SightRowMaker rowMaker_;
  Survey survey_;
  std::vector<double> changes_;                 // of what is opaque
  std::vector<int> chosen_;                     // stored times, of Survey::times
  std::optional<PendingFolder> folder_;         // of rank 0
  std::optional<SightCsv> csv_;                 // of rank 0
  std::shared_ptr<const SightSnapshot> first_;  // until its turn
  Json summary_ = Json::array();
  SurveyPage page_;
};

}  // namespace

Result<SurveySummary> runSurvey(SurveyRequest request, SightField& field, Watch& watch,
                                SurveyPictures& pictures, Progress& progress, Team& team) {
  return Job(std::move(request), field, watch, pictures, progress, team).run();
}

Result<SurveySummary> runSurvey(SurveyRequest request, SightField& field, Watch& watch,
                                SurveyPictures& pictures, Progress& progress) {
  Team alone;
  return runSurvey(std::move(request), field, watch, pictures, progress, alone);
}

}  // namespace volute
