// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/storeys.hpp"

#include <optional>

#include "volute/base/output_folder.hpp"
#include "volute/base/team_checks.hpp"
#include "volute/base/write_file.hpp"
#include "volute/report/page.hpp"

namespace volute {

Result<SurveySummary> surveyStoreys(
    std::span<const double> heights, const std::string& output, Progress& progress, Team& team,
    const std::function<Result<SurveySummary>(double, const std::string&)>& survey) {
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
  Json report = {{"heights", Json::array()}};
  std::string page;
  std::optional<SurveySummary> first;
  for (const double height : heights) {
    const std::string name = fmt::format("z_{:g}", height);
    progress.remark(fmt::format("eyes at z = {:g} m", height));
    VOLUTE_ASSIGN(auto found, survey(height, (folder / name).string()));
    if (!team.leads()) {
      first = std::move(found);
      continue;
    }
    report["heights"].push_back({{"height", height},
                                 {"folder", name},
                                 {"sight_lines", found.sightLines},
                                 {"seen_first", found.seenFirst},
                                 {"seen_last", found.seenLast}});
    VOLUTE_ASSIGN(const auto figure,
                  htmlFigure(folder / name / "aset.png",
                             fmt::format("Time from which no sign is visible, from z = {:g} m.", height)));
    page += fmt::format("<h2><a href='{0}/report.html'>Eyes at z = {1:g} m</a></h2>\n{2}", name, height,
                        figure);
    if (!first) {
      first = std::move(found);
    } else {
      first->sightLines += found.sightLines;
      first->seenFirst += found.seenFirst;
      first->seenLast += found.seenLast;
    }
  }
  const auto finish = [&]() -> Status {
    VOLUTE_TRY(writeFile(folder / kMark, dumpJson(report) + "\n"));
    VOLUTE_TRY(writePage(folder / "report.html", "Visibility of signs, storey by storey", page));
    return pending->commit();
  };
  VOLUTE_TRY(team.agree(team.leads() ? finish() : Status()));
  const double count = static_cast<double>(heights.size());
  first->seenFirst /= count, first->seenLast /= count;
  return std::move(*first);
}

}  // namespace volute
