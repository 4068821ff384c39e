// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/survey_page.hpp"

#include "volute/report/line_plot.hpp"
#include "volute/report/page.hpp"

namespace volute {
namespace {

std::string signTable(const Json& signs) {
  std::vector<HtmlRow> rows;
  for (const Json& sign : signs) {
    rows.push_back(
        {htmlOf(sign["name"]), htmlOf(sign["position"]),
         fmt::format("C = {} ({})", htmlOf(sign["C"]), htmlOf(sign["law"])),
         htmlOf(sign["angle_law"]),
         htmlOf(sign["source"]) +
             (sign["source_checked"] == true ? "" : " <b>(source not checked)</b>")});
  }
  return "<h2>Signs and criteria</h2>\n" +
         htmlTable({"sign", "position [m]", "seen while the optical depth is at most", "angle",
                    "source of C"},
                   rows);
}

std::string summaryPlot(const Json& report) {
  std::vector<double> times;
  PlotLine any{"any sign", {}, true};
  std::vector<PlotLine> lines;
  for (const Json& sign : report["signs"]) lines.push_back({sign["name"].get<std::string>(), {}});
  for (const Json& record : report["summary"]) {
    if (record["eyes"] == 0)
      continue;
    times.push_back(record["time"].get<double>());
    any.y.push_back(record["any"].get<double>());
    for (PlotLine& line : lines) line.y.push_back(record["signs"][line.name].get<double>());
  }
  if (times.size() < 2)
    return "";
  lines.insert(lines.begin(), any);
  return linePlot("Share of the eyes that see a sign", "time [s]", "share", times, lines);
}

}  // namespace

Status writeSurveyPage(const std::filesystem::path& file, const Json& report,
                       const std::string& body) {
  const Json& times = report["times"];
  return writePage(
      file, "Visibility of signs",
      fmt::format("<p>{}</p>\n<p>{} stored times, {} to {} s.</p>\n", htmlOf(report["smoke"]),
                  times.size(), times.front().dump(), times.back().dump()) +
          htmlWarnings(report["remarks"]) + signTable(report["signs"]) + summaryPlot(report) +
          body +
          "<p>S = C / K is an empirical rule: C holds for the signs, the light and the observers "
          "of the experiments behind it. docs/visibility.md of Volute says what is computed and "
          "what is not.</p>\n");
}

}  // namespace volute
