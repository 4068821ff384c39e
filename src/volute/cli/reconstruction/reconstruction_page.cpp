// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/reconstruction/reconstruction_page.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "volute/base/output_file.hpp"
#include "volute/cli/inline_picture.hpp"
#include "volute/cli/reconstruction/line_plot.hpp"
#include "volute/image/colormap.hpp"
#include "volute/image/srgb.hpp"
#include "volute/io/image_file.hpp"
#include "volute/tomography/project.hpp"

namespace volute::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kHead = R"(<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>Reconstruction</title>
<style>
body { font: 15px/1.5 sans-serif; max-width: 62em; margin: 2em auto; padding: 0 1em; color: #222; }
table { border-collapse: collapse; margin: 1em 0; } td, th { padding: .2em .8em; text-align: right; }
th { border-bottom: 1px solid #888; } td:first-child, th:first-child { text-align: left; }
.row { display: flex; gap: .5em; margin-bottom: .8em; } figure { margin: 0; flex: 1; }
img { width: 100%; image-rendering: pixelated; background: #000; } figcaption { font-size: 13px; }
.warning { background: #fff3d0; padding: .4em .8em; margin: .3em 0; }
.advice { background: #e3eef9; padding: .4em .8em; margin: .3em 0; }
</style></head><body>
)";

double numberIn(const Json& json) {
  return json.is_number() ? json.get<double>() : std::numeric_limits<double>::quiet_NaN();
}

std::string textOf(const Json& json, const char* format = "{:.4g}") {
  if (json.is_number())
    return fmt::format(fmt::runtime(format), json.get<double>());
  if (json.is_null())
    return "&ndash;";
  return escapedHtml(json.is_string() ? json.get<std::string>() : json.dump());
}

/// A share as "3.4 %".
std::string percentOf(const Json& share) {
  return share.is_number() ? fmt::format("{:.3g} %", 100 * share.get<double>()) : textOf(share);
}

/// ", PSNR 41.2 dB"; nothing where there is none.
std::string psnrText(const Json& psnr) {
  return psnr.is_number() ? ", PSNR " + textOf(psnr, "{:.2f}") + " dB" : "";
}

/// The picture as part of the page; written as a file first, in the folder of the finished frames.
Result<std::string> inlinePng(const Image& image, const std::filesystem::path& folder) {
  const auto path = folder / "frame_picture.png";
  VOLUTE_TRY(writeImage(path, image));
  return inlinePicture(path);
}

/// |projected - given|, the largest channel; 0 where pixels do not count.
Image differenceOf(const TomographyView& view, const Image& projected) {
  Image difference(projected.width, projected.height, 1);
  for (std::size_t i = 0; i < difference.pixels.size(); ++i) {
    if (!view.weight.empty() && view.weight[i] == 0)
      continue;
    for (std::size_t c = 0; c < 3; ++c) {
      difference.pixels[i] =
          std::max(difference.pixels[i],
                   std::abs(projected.pixels[3 * i + c] - view.radiance.pixels[3 * i + c]));
    }
  }
  return difference;
}

Result<std::string> figure(const Image& image, const std::string& caption,
                           const std::filesystem::path& folder) {
  VOLUTE_ASSIGN(const auto source, inlinePng(image, folder));
  return fmt::format("<figure><img src='{}' alt=''><figcaption>{}</figcaption></figure>\n", source,
                     caption);
}

/// Given, projected and difference of one camera.
Result<std::string> pictureRow(const TomographyView& view, const Image& projected,
                               const Json& camera, const std::filesystem::path& folder) {
  const double exposure = suggestExposure(view.radiance);
  const Image difference = differenceOf(view, projected);
  // A tenth of white, so that rows can be compared at a glance.
  const double scale = 0.1 / exposure;
  const auto name = escapedHtml(view.name);
  VOLUTE_ASSIGN(
      const auto given,
      figure(exposed(view.radiance, exposure),
             fmt::format("{}{}: given", name, camera["held_out"] == true ? " (held out)" : ""),
             folder));
  VOLUTE_ASSIGN(const auto seen,
                figure(exposed(projected, exposure),
                       fmt::format("projected; residual {}{}", textOf(camera["residual"]),
                                   psnrText(camera["psnr"])),
                       folder));
  VOLUTE_ASSIGN(
      const auto off,
      figure(colorMapped(difference, ColorMap::kViridis, 0, scale),
             fmt::format("difference, 0 (dark) to {:.3g} (bright): a tenth of white", scale),
             folder));
  return "<div class='row'>" + given + seen + off + "</div>\n";
}

/// The first frame, the middle one and the last.
std::set<int> shownFrames(int frames) {
  return {0, frames / 2, frames - 1};
}

Result<std::string> pictures(const Json& report, ReconstructedFrames& frames, Progress& progress) {
  std::string html;
  for (const int index : shownFrames(frames.info().frames)) {
    if (progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped: the page of the report was not written");
    VOLUTE_ASSIGN(const auto volume, frames.volume(index));
    VOLUTE_ASSIGN(const auto views, frames.views(index));
    const Json& record = report["frames"][static_cast<std::size_t>(index)];
    html += fmt::format("<h3>Frame {}</h3>\n", views.frame);
    for (std::size_t i = 0; i < views.views.size(); ++i) {
      const Image seen =
          projectVolume(volume, frames.geometry(), frames.info().basis, views.views[i].camera,
                        report["options"]["rays_per_pixel"].get<int>());
      VOLUTE_ASSIGN(const auto row,
                    pictureRow(views.views[i], seen, record["cameras"][i], frames.work().path()));
      html += row;
    }
  }
  return html;
}

std::string plots(const Json& report) {
  std::vector<double> x;
  std::vector<PlotLine> residuals;
  PlotLine iterations{"iterations", {}}, seconds{"seconds", {}}, hull{"hull share", {}};
  for (const Json& camera : report["cameras"])
    residuals.push_back({camera["name"].get<std::string>(), {}, camera["held_out"] == true});
  for (const Json& frame : report["frames"]) {
    x.push_back(numberIn(frame["frame"]));
    for (std::size_t i = 0; i < residuals.size(); ++i)
      residuals[i].y.push_back(numberIn(frame["cameras"][i]["residual"]));
    iterations.y.push_back(numberIn(frame["iterations"]));
    seconds.y.push_back(numberIn(frame["seconds"]));
    hull.y.push_back(numberIn(frame["hull_share"]));
  }
  return linePlot("Residual of each camera (dashed: held out)", "frame", "relative L2", x,
                  residuals) +
         linePlot("Iterations", "frame", "iterations", x, {iterations}) +
         linePlot("Time", "frame", "s", x, {seconds}) +
         linePlot("Unknown voxels", "frame", "share of the volume", x, {hull});
}

std::string cameraTable(const Json& report) {
  std::string html =
      "<table><tr><th>camera</th><th>residual</th><th>PSNR [dB]</th><th>gain that fits the "
      "others</th><th>saturated pixels</th><th>held out</th></tr>\n";
  for (const Json& camera : report["cameras"]) {
    html +=
        fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
                    textOf(camera["name"]), textOf(camera["residual"]),
                    textOf(camera["psnr"], "{:.2f}"), textOf(camera["gain"]),
                    percentOf(camera["saturated_share"]), camera["held_out"] == true ? "yes" : "");
  }
  return html + "</table>\n";
}

/// Degrees between the lines of sight, camera by camera.
std::string angleTable(const Json& report) {
  const Json& cameras = report["cameras"];
  std::string html = "<table><tr><th>degrees, modulo 180</th>";
  for (const Json& camera : cameras) html += "<th>" + textOf(camera["name"]) + "</th>";
  html += "</tr>\n";
  std::size_t next = 0;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    html += "<tr><td>" + textOf(cameras[i]["name"]) + "</td>";
    for (std::size_t k = 0; k < cameras.size(); ++k)
      html +=
          "<td>" + (k > i ? textOf(report["angles"][next++]["degrees"], "{:.1f}") : "") + "</td>";
    html += "</tr>\n";
  }
  return html + "</table>\n";
}

std::string summary(const Json& report) {
  const Json& volume = report["volume"];
  const Json& psnr = report["held_out_psnr"];
  const std::string heldOut =
      psnr.is_number() ? fmt::format("<tr><td>PSNR of held-out cameras</td><td>{} dB</td></tr>",
                                     textOf(psnr, "{:.2f}"))
                       : "";
  std::string html = fmt::format(
      "<h1>Reconstruction</h1>\n<p>{} ({}, pixel centres at {}), {} frames, {} voxels.</p>\n"
      "<table>"
      "<tr><td>residual of the fitted cameras (relative L2)</td><td>{}</td></tr>"
      "{}"
      "<tr><td>iterations a frame</td><td>{}</td></tr>"
      "<tr><td>unknown voxels</td><td>{} of the volume</td></tr>"
      "<tr><td>time a frame</td><td>{} s</td></tr></table>\n",
      textOf(report["capture"]), textOf(report["calibration"]), textOf(report["pixel_centre"]),
      report["frames"].size(), escapedHtml(volume["resolution"].dump()), textOf(report["residual"]),
      heldOut, textOf(report["iterations"], "{:.1f}"), textOf(report["hull_share"]),
      textOf(report["seconds_per_frame"], "{:.2f}"));
  for (const Json& warning : report["warnings"])
    html += "<div class='warning'>" + textOf(warning) + "</div>\n";
  if (report["advice"].is_string())
    html += "<div class='advice'>" + textOf(report["advice"]) + "</div>\n";
  return html;
}

}  // namespace

Status writeReconstructionPage(const std::filesystem::path& target, const Json& report,
                               ReconstructedFrames& frames, Progress& progress) {
  VOLUTE_ASSIGN(const auto shown, pictures(report, frames, progress));
  const std::string html = kHead + summary(report) + "<h2>Cameras</h2>\n" + cameraTable(report) +
                           plots(report) + "<h2>Layout</h2>\n" + angleTable(report) +
                           "<h2>Pictures</h2>\n" + shown + "</body></html>\n";
  VOLUTE_ASSIGN(auto file, OutputFile::create(target));
  VOLUTE_TRY(file.write(std::as_bytes(std::span(html))));
  return file.commit();
}

}  // namespace volute::cli
