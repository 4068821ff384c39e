// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/visibility/survey_page.hpp"

#include "volute/base/output_file.hpp"

namespace volute::cli {
namespace {

constexpr const char* kHead = R"(<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>Visibility of signs</title>
<style>
body { font: 15px/1.5 sans-serif; max-width: 64em; margin: 2em auto; padding: 0 1em; color: #222; }
table { border-collapse: collapse; margin: 1em 0; } td, th { padding: .2em .8em; text-align: left; vertical-align: top; }
th { border-bottom: 1px solid #888; } figure { margin: 1em 0; } img { max-width: 100%; }
figcaption { font-size: 13px; color: #555; }
.warning { background: #fff3d0; padding: .4em .8em; margin: .3em 0; }
</style></head><body>
)";

std::string text(const Json& json) {
  return escapedHtml(json.is_string() ? json.get<std::string>() : json.dump());
}

std::string signTable(const Json& signs) {
  std::string html =
      "<h2>Signs and criteria</h2>\n<table><tr><th>sign</th><th>position [m]</th><th>seen while "
      "the optical depth is at most</th><th>angle</th><th>source of C</th></tr>\n";
  for (const Json& sign : signs) {
    html += fmt::format(
        "<tr><td>{}</td><td>{}</td><td>C = {:.4g} ({})</td><td>{}</td><td>{}{}</td></tr>\n",
        text(sign["name"]), text(sign["position"]), sign["C"].get<double>(), text(sign["law"]),
        text(sign["angle_law"]), text(sign["source"]),
        sign["source_checked"] == true ? "" : " <b>(source not checked)</b>");
  }
  return html + "</table>\n";
}

std::string summaryPlot(const Json& report) {
  std::vector<double> times;
  PlotLine any{"any sign", {}, true};
  std::vector<PlotLine> lines;
  for (const Json& sign : report["signs"]) lines.push_back({sign["name"].get<std::string>(), {}});
  for (const Json& moment : report["summary"]) {
    if (moment["eyes"] == 0)
      continue;
    times.push_back(moment["time"].get<double>());
    any.y.push_back(moment["any"].get<double>());
    for (PlotLine& line : lines) line.y.push_back(moment["signs"][line.name].get<double>());
  }
  if (times.size() < 2)
    return "";
  lines.insert(lines.begin(), any);
  return linePlot("Share of the eyes that see a sign", "time [s]", "share", times, lines);
}

}  // namespace

Status writeSurveyPage(const std::filesystem::path& file, const Json& report,
                       const std::string& body) {
  std::string html = kHead;
  html +=
      fmt::format("<h1>Visibility of signs</h1>\n<p>{}</p>\n<p>{} stored times, {} to {} s.</p>\n",
                  text(report["smoke"]), report["times"].size(), text(report["times"].front()),
                  text(report["times"].back()));
  for (const Json& remark : report["remarks"])
    html += "<div class='warning'>" + text(remark) + "</div>\n";
  html += signTable(report["signs"]) + summaryPlot(report) + body;
  html +=
      "<p>S = C / K is an empirical rule: C holds for the signs, the light and the observers of "
      "the "
      "experiments behind it. docs/visibility.md of Volute says what is computed and what is "
      "not.</p>\n</body></html>\n";
  VOLUTE_ASSIGN(auto out, OutputFile::create(file));
  VOLUTE_TRY(out.write(std::as_bytes(std::span(html))));
  return out.commit();
}

}  // namespace volute::cli
