// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/storeys.hpp"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "volute/base/output_folder.hpp"
#include "volute/base/plain_number.hpp"
#include "volute/base/team_checks.hpp"
#include "volute/base/write_file.hpp"
#include "volute/report/pdf.hpp"
#include "volute/visibility/survey_page.hpp"

namespace volute {
namespace {

/// From when on a verdict is not sure that nothing is lost [s].
double sureUntil(const Json& verdict) {
  constexpr double kAlways = std::numeric_limits<double>::infinity();
  const Json known = verdict.value("known", Json(true)), time = verdict.value("time", Json());
  if (known.is_number())
    return known.get<double>();
  if (known == false)
    return -kAlways;
  return time.is_number() ? time.get<double>() : kAlways;
}

/// Of each criterion that has a time the verdict of the storey where it comes first, with the
/// height. One that is not known comes first from when on it is not.
Json worstVerdicts(const Json& storeys) {
  Json worst = Json::array();
  for (const Json& storey : storeys) {
    for (const Json& one : storey["verdict"]) {
      if (!one.contains("time"))
        continue;
      Json with = one;
      with["height"] = storey["height"];
      const auto known = std::ranges::find(
          worst, one["criterion"], [](const Json& w) -> const Json& { return w["criterion"]; });
      if (known == worst.end())
        worst.push_back(std::move(with));
      else if (sureUntil(one) < sureUntil(*known))
        *known = std::move(with);
    }
  }
  return worst;
}

/// "z_1.8", with all its digits if another height has the same first six.
std::string folderOf(double height, std::span<const double> heights) {
  const auto rounded = [](double z) { return fmt::format("z_{:g}", z); };
  const std::string name = rounded(height);
  return std::ranges::count(heights, name, rounded) > 1 ? fmt::format("z_{}", height) : name;
}

}  // namespace

Result<SurveySummary> surveyStoreys(
    std::span<const double> heights, const std::string& output, bool pdf, Progress& progress,
    Team& team, const std::function<Result<SurveySummary>(double, const std::string&)>& survey) {
  constexpr std::string_view kMark = "visibility.json";
  VOLUTE_TRY(checkFolderIsShared(output, team));
  std::optional<PendingFolder> pending;
  Status made;
  if (team.leads()) {
    auto folder = PendingFolder::create(output, kMark);
    if (folder)
      pending.emplace(std::move(*folder));
    else
      made = tl::unexpected(std::move(folder.error()));
  }
  VOLUTE_TRY(team.agree(made));
  VOLUTE_ASSIGN(const auto paths, team.gatherTexts(pending ? pending->path().string() : ""));
  const std::filesystem::path folder = paths.front();
  SurveySummary all;
  std::vector<SurveyPage> pages;
  Json list = Json::array();
  for (const double height : heights) {
    const std::string name = folderOf(height, heights);
    progress.remark(fmt::format("eyes at z = {} m", plainNumber(height)));
    VOLUTE_ASSIGN(auto found, survey(height, (folder / name).string()));
    all.times = std::move(found.times);
    if (!team.leads())
      continue;
    all.sightLines += found.sightLines;
    all.seenFirst += found.seenFirst / static_cast<double>(heights.size());
    all.seenLast += found.seenLast / static_cast<double>(heights.size());
    for (const std::string& sentence : found.verdict)
      all.verdict.push_back(fmt::format("z = {} m: {}", plainNumber(height), sentence));
    list.push_back({{"height", height},
                    {"folder", name},
                    {"sight_lines", found.sightLines},
                    {"seen_first", found.seenFirst},
                    {"seen_last", found.seenLast},
                    {"verdict", found.page.report.value("verdict", Json::array())}});
    pages.push_back(std::move(found.page));
  }
  const auto finish = [&]() -> Status {
    const std::filesystem::path page = folder / "report.html";
    VOLUTE_TRY(writeStoreysPage(page, heights, pages));
    if (pdf) {
      if (const auto printed = printPdf(page, folder / "report.pdf"); !printed)
        progress.remark({RemarkCode::kLeftOut, printed.error().message});
    }
    const Json report = {{"format", "volute-visibility-1"},
                         {"case", pages.front().report["case"]},
                         {"times", all.times},
                         {"verdict", worstVerdicts(list)},
                         {"heights", list}};
    VOLUTE_TRY(writeFile(folder / kMark, dumpJson(report) + "\n"));
    return pending->commit();
  };
  VOLUTE_TRY(team.agree(team.leads() ? finish() : Status()));
  return all;
}

}  // namespace volute
