// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/survey_page.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "volute/base/plain_number.hpp"
#include "volute/report/line_plot.hpp"
#include "volute/report/page.hpp"

namespace volute {
namespace {

constexpr const char* kTitle = "Tenability and sight of signs";

std::string verdictBoxes(const Json& report) {
  std::string html;
  if (report.contains("verdict")) {
    for (const Json& one : report["verdict"])
      html += fmt::format("<div class='verdict'>{}</div>\n", htmlOf(one["sentence"]));
  }
  return html;
}

/// The answer, before everything else.
std::string verdictPart(const std::string& boxes) {
  return boxes.empty() ? "" : "<h2>Verdict</h2>\n" + boxes;
}

/// How many, from when to when, and what is lost between them.
std::string storedTimes(const Json& list) {
  const auto times = list.get<std::vector<double>>();
  double apart = 0;
  for (std::size_t i = 1; i < times.size(); ++i) apart = std::max(apart, times[i] - times[i - 1]);
  const std::string span = fmt::format("{}, {} to {} s", times.size(), plainNumber(times.front()),
                                       plainNumber(times.back()));
  if (times.size() < 2)
    return span;
  return span +
         fmt::format(
             ", up to {:.3g} s apart. <b>A sign that is lost and seen again within {:.3g} s "
             "may not count as lost</b>: what happens between two stored times is not in the "
             "files (FDS: DT_SLCF, DT_SMOKE3D)",
             apart, apart);
}

/// What is stated of the report; its own name else.
std::string titleOf(const Json& report) {
  const Json document = report.value("document", Json::object());
  const Json title = document.value("title", Json());
  return title.is_string() ? title.get<std::string>() : kTitle;
}

std::string titlePart(const Json& report) {
  if (!report.contains("title_block"))
    return "";
  std::vector<HtmlRow> rows;
  const Json document = report.value("document", Json::object());
  if (document.value("project", Json()).is_string())
    rows.push_back({"project", htmlOf(document["project"])});
  for (const auto& [name, value] : report["title_block"].items())
    rows.push_back({escapedHtml(name), htmlOf(value)});
  const Json& times = report["times"];
  rows.push_back({"smoke from", htmlOf(report["smoke"])});
  rows.push_back({"stored times", storedTimes(times)});
  const std::string round = report["round"].get<std::string>();
  rows.push_back({"times between stored ones are given",
                  round == "down" ? "as the last stored time before the change (safe side)"
                  : round == "up" ? "as the first stored time after the change"
                                  : "interpolated"});
  return "<h2>The study</h2>\n" + htmlTable({}, rows);
}

/// What was assumed, and what is missing.
std::string remarksPart(const Json& remarks) {
  return remarks.empty() ? "" : "<h2>Assumptions and remarks</h2>\n" + htmlWarnings(remarks);
}

/// Which files were read, so that somebody else may read the same.
std::string inputsPart(const Json& report) {
  if (!report.contains("document") || report["document"]["inputs"].empty())
    return "";
  std::vector<HtmlRow> rows;
  for (const Json& one : report["document"]["inputs"])
    rows.push_back({htmlOf(one["file"]), htmlOf(one["bytes"], "{}"), htmlOf(one["sha256"])});
  return "<h2>Input files</h2>\n<p>Checksums are of the files as they were read; of an FDS case of "
         "its index and input, not of its data.</p>\n" +
         htmlTable({"file", "bytes", "SHA-256"}, rows);
}

/// Room for names and signatures.
std::string signaturePart(const Json& report) {
  const Json document = report.value("document", Json::object());
  const auto of = [&](const char* key) {
    const Json value = document.value(key, Json());
    return value.is_string() ? htmlOf(value) : std::string(24, '_');
  };
  const std::string line(24, '_');
  return "<h2>Signatures</h2>\n" +
         htmlTable({"", "name", "date", "signature"},
                   {{"author", of("author"), of("date"), line}, {"checked by", line, line, line}});
}

/// A curve's plot of a few hundred points at most.
std::string curvePlot(const std::string& title, const std::string& unit,
                      const std::vector<const Json*>& curves) {
  constexpr std::size_t kPoints = 400;
  const auto times = (*curves[0])["times"].get<std::vector<double>>();
  const std::size_t every = std::max<std::size_t>(1, times.size() / kPoints);
  std::vector<double> x;
  for (std::size_t i = 0; i < times.size(); i += every) x.push_back(times[i]);
  std::vector<PlotLine> lines;
  for (const Json* curve : curves) {
    const Json& values = (*curve)["values"];
    if (values.size() != times.size())
      continue;
    PlotLine line{(*curve)["name"].get<std::string>(), {}};
    for (std::size_t i = 0; i < times.size(); i += every) line.y.push_back(values[i].get<double>());
    lines.push_back(std::move(line));
  }
  return x.size() < 2 || lines.empty() ? "" : linePlot(title, "time [s]", unit, x, lines);
}

/// Heat release, and devices of the same unit together.
std::string firePart(const Json& report) {
  if (!report.contains("fire"))
    return "";
  std::string html;
  for (const Json& curve : report["fire"])
    html += curvePlot("Heat release rate", curve["unit"].get<std::string>(), {&curve});
  std::map<std::string, std::vector<const Json*>> byUnit;
  constexpr std::size_t kLines = 8, kPlots = 4;
  for (const Json& curve : report["devices"]) {
    const bool negative = std::ranges::any_of(curve["values"], [](const Json& value) {
      return value.is_number() && value.get<double>() < 0;
    });
    if (negative)
      continue;  // plots begin at 0
    auto& curves = byUnit[curve["unit"].get<std::string>()];
    if (curves.size() < kLines)
      curves.push_back(&curve);
  }
  std::size_t plots = 0;
  for (const auto& [unit, curves] : byUnit) {
    if (plots++ < kPlots)
      html += curvePlot(fmt::format("Devices [{}]", unit), unit, curves);
  }
  const std::size_t devices = report["devices"].size();
  if (devices > 0)
    html += fmt::format(
        "<p>{} devices in visibility.json; up to {} of a unit are drawn, none that goes below "
        "0.</p>\n",
        devices, kLines);
  return html.empty() ? "" : "<h2>Fire</h2>\n" + html;
}

std::string signTable(const Json& signs) {
  std::vector<HtmlRow> rows;
  for (const Json& sign : signs) {
    rows.push_back({htmlOf(sign["name"]), htmlOf(sign["position"]),
                    fmt::format("C = {} ({})", htmlOf(sign["C"]), htmlOf(sign["law"])),
                    htmlOf(sign["angle_law"]),
                    htmlOf(sign["source"]) +
                        (sign["source_checked"] == true ? "" : " <b>(source not checked)</b>")});
  }
  return "<h2>Signs and criteria of sight</h2>\n" +
         htmlTable({"sign", "position [m]", "seen while the optical depth is at most", "angle",
                    "source of C"},
                   rows);
}

/// Which criteria were asked for, above their table.
std::string profilePart(const Json& report) {
  if (!report.contains("criteria_profile"))
    return "";
  const Json& profile = report["criteria_profile"];
  HtmlRow row{"criteria of tenability", htmlOf(profile["title"])};
  row.back() += ". Source: " + htmlOf(profile["source"]);
  if (profile["applies"] != "")
    row.back() += ". For: " + htmlOf(profile["applies"]);
  return htmlTable({}, {row});
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
  return "<h2>Signs over time</h2>\n" +
         linePlot("Share of the eyes that see a sign", "time [s]", "share", times, lines);
}

constexpr const char* kLimits =
    R"(<h2>Limits of validity</h2>
<ul>
<li>S = C / K is an empirical rule: C holds for the signs, the light and the observers of the
experiments behind it. A sign's luminance, its size and the room's light are not in it.</li>
<li>Between stored times optical depths, temperatures and concentrations are linear. What happens and
is over between two stored times is not seen; how far apart they are stands at the top. The row of the
sensitivity that counts depths within 2 % of their limit as lost tells how much that may matter.</li>
<li>Doses are of people who stand or walk where the plan or the route says; what they took in before
is not known. A fractional dose of 1 is that at which half of the people are affected, by the models
named above; which people they are is not looked at.</li>
<li>Gases that the case does not store count as not there: what the criteria's table names so makes
doses too small.</li>
<li>The fire, its soot and its gases are those of the simulation. What cells of another size would
give can be told by another simulation alone.</li>
</ul>
<p>docs/visibility.md and docs/tenability.md of Volute say what is computed and what is not.</p>
)";

}  // namespace

Status writeSurveyPage(const std::filesystem::path& file, const SurveyPage& page) {
  const Json& report = page.report;
  return writePage(file, titleOf(report),
                   verdictPart(verdictBoxes(report)) + titlePart(report) + firePart(report) +
                       signTable(report["signs"]) + profilePart(report) +
                       remarksPart(report["remarks"]) + summaryPlot(report) + page.body + kLimits +
                       inputsPart(report) + signaturePart(report));
}

namespace {

/// How the ASET depends on the height of the eyes: of heights on one storey, a sensitivity.
std::string heightsTable(std::span<const double> heights, std::span<const SurveyPage> storeys) {
  std::vector<HtmlRow> rows;
  for (std::size_t i = 0; i < storeys.size(); ++i) {
    const Json verdict = storeys[i].report.value("verdict", Json::array());
    const auto all =
        std::ranges::find_if(verdict, [](const Json& one) { return one["criterion"] == "all"; });
    if (all == verdict.end())
      return "";
    const bool known = (*all)["known"] == true, reached = (*all)["time"].is_number();
    rows.push_back({plainNumber(heights[i]),
                    !known    ? "not known"
                    : reached ? htmlOf((*all)["time"], "{:.4g}")
                              : "not reached",
                    known && reached ? htmlOf((*all)["time_interpolated"], "{:.4g}") : "\u2013",
                    known && reached ? htmlOf((*all)["by"]) : "\u2013"});
  }
  return "<h3>By the height of the eyes</h3>\n" +
         htmlTable({"eyes at z [m]", "ASET [s]", "interpolated [s]", "by"}, rows,
                   HtmlAlign::kNumbers);
}

}  // namespace

Status writeStoreysPage(const std::filesystem::path& file, std::span<const double> heights,
                        std::span<const SurveyPage> storeys) {
  std::string verdict, parts;
  for (std::size_t i = 0; i < storeys.size(); ++i) {
    const auto& [report, body] = storeys[i];
    const std::string boxes = verdictBoxes(report);
    if (!boxes.empty())
      verdict += fmt::format("<h3><a href='#storey{}'>Eyes at z = {} m</a></h3>\n{}", i,
                             plainNumber(heights[i]), boxes);
    parts += fmt::format(
        "<section class='part' id='storey{}'><h1>Eyes at z = {} m</h1>\n{}{}{}</section>\n", i,
        plainNumber(heights[i]), htmlWarnings(report["remarks"]), summaryPlot(report), body);
  }
  const Json& first = storeys.front().report;
  return writePage(file, titleOf(first),
                   verdictPart(verdict + heightsTable(heights, storeys)) + titlePart(first) +
                       firePart(first) + signTable(first["signs"]) + profilePart(first) + parts +
                       kLimits + inputsPart(first) + signaturePart(first));
}

}  // namespace volute
