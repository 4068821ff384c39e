// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/study.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "volute/base/file_name.hpp"
#include "volute/base/number_word.hpp"
#include "volute/base/plain_number.hpp"
#include "volute/base/read_text.hpp"
#include "volute/io/image_file.hpp"
#include "volute/io/json_file.hpp"
#include "volute/io/json_members.hpp"
#include "volute/io/json_values.hpp"
#include "volute/report/csv_cell.hpp"
#include "volute/visibility/criteria_file.hpp"
#include "volute/visibility/plan_picture.hpp"
#include "volute/visibility/plan_vti.hpp"

namespace volute {
namespace {

constexpr std::size_t kMaxRuns = 100000;
constexpr const char* kMinMargin = "least margin [s]";

/// Options whose values are files.
constexpr std::array<std::string_view, 8> kFiles{"signs", "route",    "eyes",  "trajectories",
                                                 "rset",  "criteria", "areas", "underlay"};

/// Whether the value of an option for files is none: seconds, or the name of criteria.
bool isNoFile(std::string_view option, const std::string& value, const std::string& file) {
  double seconds = 0;
  if (option == "rset")
    return readNumber(value, seconds);
  if (option != "criteria")
    return false;
  std::error_code error;
  const auto names = criteriaNames();
  return value == "none" || std::ranges::find(names, value) != names.end() ||
         (value.find_first_of("./\\") == value.npos && !std::filesystem::exists(file, error));
}

std::string plainName(const std::string& text) {
  std::string name;
  for (const char c : text) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       c == '-' || c == '_' || (c == '.' && !name.empty());
    name += plain ? c : '_';
  }
  return name.empty() ? "run" : name;
}

using OptionSet = std::map<std::string, std::vector<std::string>>;

class StudyReader {
 public:
  StudyReader(const nlohmann::json& json, const std::string& file) : json_(json), file_(file) {}

  Result<Study> read() {
    if (!json_.is_object())
      return wrong("", "expected an object");
    constexpr std::array<std::string_view, 5> kNames{"format", "cases", "options", "variants",
                                                     "baseline"};
    VOLUTE_TRY(checkMembers(json_, kNames, file_));
    VOLUTE_ASSIGN(const OptionSet common, options(json_, ""));
    VOLUTE_TRY(readVariants());
    if (!json_.contains("cases") || !json_["cases"].is_array() || json_["cases"].empty())
      return wrong("/cases", "expected a list of .smv files, folders or objects with 'case'");
    Study study;
    for (std::size_t i = 0; i < json_["cases"].size(); ++i)
      VOLUTE_TRY(addCases(json_["cases"][i], fmt::format("/cases/{}", i), common, study));
    if (json_.contains("baseline")) {
      if (!json_["baseline"].is_string())
        return wrong("/baseline", "expected a run's name");
      study.baseline = json_["baseline"].get<std::string>();
      if (std::ranges::find(study.runs, study.baseline, &StudyRun::name) == study.runs.end())
        return wrong("/baseline", fmt::format("no run is named '{}'; the first is '{}'",
                                              study.baseline, study.runs.front().name));
    }
    return study;
  }

 private:
  struct Variant {
    std::string name;
    OptionSet options;
  };

  tl::unexpected<Error> wrong(const std::string& where, std::string_view message) const {
    return fail(ErrorCode::kInvalidData, "{}: {}: {}", file_, where.empty() ? "/" : where, message);
  }

  Result<std::string> word(const nlohmann::json& value, const std::string& key,
                           const std::string& where) const {
    std::string text = value.is_string() ? value.get<std::string>() : value.dump();
    if (!value.is_string() && !value.is_number())
      return wrong(where, "expected a text, a number, true, or a list of texts and numbers");
    if (std::ranges::find(kFiles, key) == kFiles.end() || !value.is_string())
      return text;
    std::string file = besides(file_, text);
    return isNoFile(key, text, file) ? text : file;
  }

  Result<OptionSet> options(const nlohmann::json& json, const std::string& where) const {
    OptionSet set;
    if (!json.contains("options"))
      return set;
    if (!json["options"].is_object())
      return wrong(where + "/options", "expected an object: {\"height\": 2}");
    for (const auto& [key, value] : json["options"].items()) {
      const std::string at = fmt::format("{}/options/{}", where, key);
      if (key == "output" || key == "o")
        return wrong(at, "each run has a folder of its own below the study's: leave it out");
      auto& words = set[key];
      if (value.is_boolean()) {
        if (!value.get<bool>())
          return wrong(at, "expected true, or leave it out");
        continue;
      }
      if (!value.is_array()) {
        VOLUTE_ASSIGN(const auto one, word(value, key, at));
        words.push_back(one);
        continue;
      }
      for (const nlohmann::json& item : value) {
        VOLUTE_ASSIGN(const auto one, word(item, key, at));
        words.push_back(one);
      }
    }
    return set;
  }

  Result<std::string> name(const nlohmann::json& json, const std::string& where,
                           const std::string& initial) const {
    if (!json.contains("name"))
      return initial;
    if (!json["name"].is_string() || json["name"].get<std::string>().empty())
      return wrong(where + "/name", "expected a text");
    return json["name"].get<std::string>();
  }

  Status readVariants() {
    if (!json_.contains("variants")) {
      variants_.push_back({});
      return {};
    }
    const nlohmann::json& list = json_["variants"];
    if (!list.is_array() || list.empty())
      return wrong("/variants", "expected a list of objects with name and options");
    constexpr std::array<std::string_view, 2> kNames{"name", "options"};
    for (std::size_t i = 0; i < list.size(); ++i) {
      const std::string where = fmt::format("/variants/{}", i);
      if (!list[i].is_object())
        return wrong(where, "expected an object with name and options");
      VOLUTE_TRY(checkMembers(list[i], kNames, file_, where));
      Variant variant;
      VOLUTE_ASSIGN(variant.name, name(list[i], where, fmt::format("variant{}", i + 1)));
      VOLUTE_ASSIGN(variant.options, options(list[i], where));
      variants_.push_back(std::move(variant));
    }
    return {};
  }

  Status addCases(const nlohmann::json& json, const std::string& where, const OptionSet& common,
                  Study& study) {
    constexpr std::array<std::string_view, 3> kNames{"case", "name", "options"};
    const bool plain = json.is_string();
    if (!plain && (!json.is_object() || !json.contains("case") || !json["case"].is_string()))
      return wrong(where, "expected a file or a folder, or an object with 'case'");
    OptionSet own;
    std::string named;
    if (!plain) {
      VOLUTE_TRY(checkMembers(json, kNames, file_, where));
      VOLUTE_ASSIGN(own, options(json, where));
      VOLUTE_ASSIGN(named, name(json, where, ""));
    }
    const std::string path = besides(file_, (plain ? json : json["case"]).get<std::string>());
    VOLUTE_ASSIGN(const auto files, filesOf(path, where));
    for (const auto& file : files) {
      std::string title = named;
      if (title.empty() || files.size() > 1) {
        const auto below = std::filesystem::path(file).lexically_relative(path);
        auto stem = files.size() > 1 ? below : std::filesystem::path(file).filename();
        title = (title.empty() ? "" : title + "_") + stem.replace_extension().generic_string();
      }
      for (const Variant& variant : variants_)
        VOLUTE_TRY(addRun(title, file, own, variant, common, study));
    }
    return {};
  }

  Status addRun(const std::string& title, const std::string& file, const OptionSet& own,
                const Variant& variant, const OptionSet& common, Study& study) {
    if (study.runs.size() == kMaxRuns)
      return wrong("/cases", fmt::format("more than {} runs", kMaxRuns));
    StudyRun run;
    const std::string wanted =
        plainName(title) + (variant.name.empty() ? "" : "_" + plainName(variant.name));
    run.name = wanted;
    for (int n = 2; !names_.insert(run.name).second; ++n)
      run.name = fmt::format("{}_{}", wanted, n);
    run.casePath = file;
    run.variant = variant.name;
    OptionSet all = variant.options;
    all.insert(own.begin(), own.end());
    all.insert(common.begin(), common.end());
    for (const auto& [key, values] : all) {
      if (values.empty())
        run.words.push_back("--" + key);
      for (const std::string& value : values)
        run.words.push_back(fmt::format("--{}={}", key, value));
    }
    std::error_code error;
    std::vector<std::string> same = run.words;
    same.push_back(std::filesystem::weakly_canonical(file, error).string());
    if (const auto [other, isNew] = runs_.emplace(std::move(same), run.name); !isNew)
      return wrong("/cases", fmt::format("{} is there twice with the same options, as {} and {}; "
                                         "expected it once",
                                         file, other->second, run.name));
    study.runs.push_back(std::move(run));
    return {};
  }

  /// The file itself, or all cases in and below a folder, in order.
  Result<std::vector<std::string>> filesOf(const std::string& path,
                                           const std::string& where) const {
    std::error_code error;
    if (!std::filesystem::is_directory(path, error))
      return std::vector{path};
    std::vector<std::string> files;
    std::filesystem::recursive_directory_iterator entries(path, error), end;
    for (; !error && entries != end; entries.increment(error)) {
      if (extensionOf(entries->path()) == ".smv" && entries->is_regular_file(error))
        files.push_back(entries->path().string());
      if (files.size() > kMaxRuns)
        break;
    }
    if (error)
      return wrong(where, fmt::format("{}: {}", path, error.message()));
    if (files.empty())
      return wrong(where, fmt::format("{}: no .smv file in or below this folder", path));
    std::ranges::sort(files);
    return files;
  }

  const nlohmann::json& json_;
  const std::string& file_;
  std::vector<Variant> variants_;
  std::set<std::string> names_;
  std::map<std::vector<std::string>, std::string> runs_;  // by options and case
};

/// This program's own, which may be long.
Result<Json> readOwnJson(const std::filesystem::path& path) {
  VOLUTE_ASSIGN(const auto text, readText(path, std::uint64_t{1} << 30));
  Json json = Json::parse(text, nullptr, false);
  if (json.is_discarded() || !json.is_object())
    return fail(ErrorCode::kInvalidData, "{}: is no JSON object", path.string());
  return json;
}

}  // namespace

Result<Study> Study::read(const std::string& file) {
  VOLUTE_ASSIGN(const auto json, readJson(file));
  return StudyReader(json, file).read();
}

void StudyResults::put(std::map<std::string, std::string>& row, const std::string& column,
                       std::string value) {
  if (std::ranges::find(columns_, column) == columns_.end())
    columns_.push_back(column);
  row[column] = std::move(value);
}

void StudyResults::addFailure(const StudyRun& run, const std::string& sentence) {
  auto& row = rows_.emplace_back();
  put(row, "run", run.name);
  put(row, "case", run.casePath);
  put(row, "variant", run.variant);
  put(row, "done", "0");
  put(row, "why", sentence);
}

Status StudyResults::add(const StudyRun& run, const std::filesystem::path& folder) {
  const auto file = folder / "visibility.json";
  VOLUTE_ASSIGN(const auto json, readOwnJson(file));
  try {
    std::vector<Json> storeys;
    for (const Json& one : json.value("heights", Json::array())) {
      const std::filesystem::path name = one.at("folder").get<std::string>();
      VOLUTE_ASSIGN(auto storey, readOwnJson(folder / name.filename() / "visibility.json"));
      storey["storey"] = name.filename().string();
      storeys.push_back(std::move(storey));
    }
    addResult(run, json, storeys.empty() ? std::span(&json, 1) : std::span<const Json>(storeys));
  } catch (const Json::exception& error) {
    return fail(ErrorCode::kInvalidData,
                "{}: is not what a survey writes ({}); delete {} to do this run again",
                file.string(), error.what(), folder.string());
  }
  return {};
}

/// @param storeys  the report of each plan; of a single one that is `json`
void StudyResults::addResult(const StudyRun& run, const Json& json, std::span<const Json> storeys) {
  std::map<std::string, std::string> row;
  put(row, "run", run.name);
  put(row, "case", run.casePath);
  put(row, "variant", run.variant);
  put(row, "done", "1");
  put(row, "why", "");
  const Json times = json.value("times", Json::array());
  put(row, "stored_times", std::to_string(times.size()));
  if (!times.empty()) {
    put(row, "first_time", times.front().dump());
    put(row, "last_time", times.back().dump());
  }
  for (const Json& one : json.value("verdict", Json::array())) {
    const std::string criterion = one.value("criterion", "");
    if (one.contains("time")) {
      const bool reached = one["time"].is_number();
      put(row, criterion + " [s]", reached ? one["time"].dump() : "");
      const Json known = one.value("known", Json(true));
      put(row, criterion + ", known",
          known.is_boolean() ? (known == true ? "yes" : "no") : "until " + known.dump());
      // To sort by: what is not known may be reached as soon as its data end.
      put(row, criterion + ", not before [s]",
          known.is_number() ? known.dump()
          : times.empty()   ? ""
          : known == false  ? times.front().dump()
          : reached         ? one["time"].dump()
                            : json.value("end", times.back()).dump());
      put(row, criterion + ", interpolated [s]",
          reached ? one.value("time_interpolated", Json()).dump() : "");
      if (one.contains("height"))
        put(row, criterion + ", height [m]", reached ? one["height"].dump() : "");
      put(row, criterion + ", share", reached ? one.value("share", Json(0)).dump() : "0");
    }
    if (one.contains("sign"))
      put(row, "first sign lost", one["sign"].is_string() ? one["sign"].get<std::string>() : "");
  }
  Json margin;  // the smallest
  bool marginKnown = true;
  std::size_t remarks = 0;
  std::vector<Plan> plans;
  for (const Json& storey : storeys) {
    if (storey.contains("tenability") && storey["tenability"].contains("margin")) {
      const Json& own = storey["tenability"]["margin"];
      if (!row.contains(kMinMargin))
        put(row, kMinMargin, "");
      marginKnown = marginKnown && own.value("known", true);
      if (own.contains("least") && (margin.is_null() || own["least"].at("value") < margin))
        margin = own["least"].at("value");
    }
    remarks += storey.value("remarks", Json::array()).size();
    if (auto plan = planOf(run.name, storey))
      plans.push_back(std::move(*plan));
  }
  if (!margin.is_null() && marginKnown)
    put(row, kMinMargin, margin.dump());
  if (row.contains(kMinMargin))
    put(row, "least margin, known", marginKnown ? "yes" : "no");
  put(row, "remarks", std::to_string(remarks));
  std::ranges::move(plans, std::back_inserter(plans_));
  rows_.push_back(std::move(row));
}

std::optional<StudyResults::Plan> StudyResults::planOf(const std::string& run, const Json& json) {
  const Json eyes = json.value("eyes", Json::object());
  if (eyes.value("kind", "") != "plan" || !json.contains("plan") || !json.contains("times"))
    return std::nullopt;
  Plan plan;
  plan.run = run;
  plan.storey = json.value("storey", "");
  const Json& origin = eyes.at("origin");
  plan.plan.origin = Vec3(origin.at(0), origin.at(1), eyes.at("height"));
  plan.plan.step = eyes.at("step");
  plan.plan.nx = eyes.at("nx");
  plan.plan.ny = eyes.at("ny");
  if (json.at("times").empty())
    return std::nullopt;
  plan.end = json.at("times").back();
  const Json& aset = json.contains("tenability") && json["tenability"].contains("aset")
                         ? json["tenability"]["aset"]
                         : json.at("aset").at(0);
  const Json& rows = aset.at("rows");
  const Json knowns = aset.value("rows_known", Json());  // of older results: none
  for (int y = 0; y < plan.plan.ny; ++y) {
    const auto line = static_cast<std::size_t>(y);
    const std::string walkable = json.at("plan").at(line);
    for (int x = 0; x < plan.plan.nx; ++x) {
      const auto column = static_cast<std::size_t>(x);
      const bool gas = column < walkable.size() && walkable[column] == '1';
      const Json& value = rows.at(line).at(column);
      plan.plan.places.push_back(gas ? Place::kGas : Place::kSolid);
      const bool known = knowns.is_null() || knowns.at(line).at(column) == true;
      plan.aset.push_back(!gas || !known      ? std::numeric_limits<float>::quiet_NaN()
                          : value.is_number() ? value.get<float>()
                                              : std::numeric_limits<float>::infinity());
    }
  }
  return plan;
}

std::string StudyResults::table() const {
  std::string text;
  for (std::size_t c = 0; c < columns_.size(); ++c)
    text.append(c > 0 ? "," : "").append(csvCell(columns_[c]));
  text += '\n';
  for (const auto& row : rows_) {
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      const auto found = row.find(columns_[c]);
      text.append(c > 0 ? "," : "").append(found == row.end() ? "" : csvCell(found->second));
    }
    text += '\n';
  }
  return text;
}

/// A place that keeps its signs to the end counts as lost at the end: it is at least that.
float StudyResults::Plan::timeAt(std::size_t i) const {
  return std::isinf(aset[i]) ? static_cast<float>(end) : aset[i];
}

std::vector<StudyResults::Comparison> StudyResults::comparisons(
    std::vector<std::string>& remarks) const {
  if (plans_.empty())
    return {};
  const auto found = std::ranges::find(plans_, baseline_, &Plan::run);
  const std::string& base = found == plans_.end() ? plans_.front().run : baseline_;
  std::vector<Comparison> all;
  for (const Plan& plan : plans_) {
    if (plan.run == base)
      all.push_back({&plan, {}, plan.storey.empty() ? "" : "_" + plan.storey});
  }
  for (const Plan& plan : plans_) {
    const auto same = std::ranges::find_if(all, [&](const Comparison& one) {
      const FloorPlan &a = plan.plan, &b = one.base->plan;
      return a.nx == b.nx && a.ny == b.ny && std::abs(a.step - b.step) < 1e-9 &&
             (a.origin - b.origin).norm() < 1e-6;
    });
    if (same != all.end()) {
      same->plans.push_back(&plan);
      continue;
    }
    const std::string where =
        plan.storey.empty() ? "" : fmt::format(" at z = {} m", plainNumber(plan.plan.origin[2]));
    remarks.push_back(fmt::format("run '{}' has another plan{} than '{}': it is not compared",
                                  plan.run, where, base));
  }
  return all;
}

Status StudyResults::writeDifference(const Plan& plan, const Comparison& comparison,
                                     const std::filesystem::path& folder) {
  const Plan& base = *comparison.base;
  std::vector<float> difference(base.aset.size());
  PlanPicture picture;
  picture.title = fmt::format("ASET of {} minus that of {}", plan.run, base.run);
  if (!comparison.name.empty())
    picture.title += fmt::format(", z = {} m", plainNumber(base.plan.origin[2]));
  picture.barLabel = "difference [s]";
  picture.values.assign(base.aset.size(), 0);
  picture.marks.assign(base.aset.size(), PlanMark::kUnknown);
  double most = 1e-9;
  for (std::size_t i = 0; i < difference.size(); ++i) {
    difference[i] = plan.timeAt(i) - base.timeAt(i);
    if (std::isnan(difference[i]))
      continue;
    picture.values[i] = difference[i];
    picture.marks[i] = PlanMark::kValue;
    most = std::max(most, std::abs(picture.values[i]));
  }
  picture.low = -most;
  picture.high = most;
  picture.words = {{PlanMark::kUnknown, "solid, or no data in one of them"}};
  const std::string name = plan.run + comparison.name + "_difference";
  VOLUTE_TRY(writePlanVti(folder / (name + ".vti"), base.plan, {{"difference", difference}}));
  return writeImage(folder / (name + ".png"), drawPlan(base.plan, picture, {}));
}

Status StudyResults::writeSpread(const Comparison& comparison,
                                 const std::filesystem::path& folder) {
  const std::size_t count = comparison.base->aset.size();
  const float none = std::numeric_limits<float>::quiet_NaN();
  std::vector<float> least(count, none), mean(count, none), largest(count, none),
      spread(count, none);
  for (std::size_t i = 0; i < count; ++i) {
    double sum = 0, squares = 0, low = 0, high = 0;
    int n = 0;
    for (const Plan* plan : comparison.plans) {
      const double time = plan->timeAt(i);
      if (std::isnan(time))
        continue;
      low = n == 0 ? time : std::min(low, time);
      high = n == 0 ? time : std::max(high, time);
      sum += time;
      squares += time * time;
      ++n;
    }
    if (n == 0)
      continue;
    least[i] = static_cast<float>(low);
    largest[i] = static_cast<float>(high);
    mean[i] = static_cast<float>(sum / n);
    spread[i] = static_cast<float>(std::sqrt(std::max(0.0, squares / n - sum / n * sum / n)));
  }
  return writePlanVti(folder / ("spread" + comparison.name + ".vti"), comparison.base->plan,
                      {{"aset_least", least},
                       {"aset_mean", mean},
                       {"aset_largest", largest},
                       {"aset_standard_deviation", spread}});
}

Result<std::vector<std::string>> StudyResults::compare(const std::filesystem::path& folder) const {
  std::vector<std::string> remarks;
  for (const Comparison& comparison : comparisons(remarks)) {
    if (comparison.plans.size() < 2)
      continue;
    for (const Plan* plan : comparison.plans) {
      if (plan != comparison.base)
        VOLUTE_TRY(writeDifference(*plan, comparison, folder));
    }
    VOLUTE_TRY(writeSpread(comparison, folder));
  }
  return remarks;
}

}  // namespace volute
