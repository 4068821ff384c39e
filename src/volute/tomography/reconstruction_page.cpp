// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/reconstruction_page.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "volute/image/colormap.hpp"
#include "volute/image/srgb.hpp"
#include "volute/io/image_file.hpp"
#include "volute/report/line_plot.hpp"
#include "volute/report/page.hpp"
#include "volute/tomography/project.hpp"

namespace volute {
namespace {

double numberIn(const Json& json) {
  return json.is_number() ? json.get<double>() : std::numeric_limits<double>::quiet_NaN();
}

/// A share as "3.4 %".
std::string percentOf(const Json& share) {
  return share.is_number() ? fmt::format("{:.3g} %", 100 * share.get<double>()) : htmlOf(share);
}

/// ", PSNR 41.2 dB"; nothing where there is none.
std::string psnrText(const Json& psnr) {
  return psnr.is_number() ? ", PSNR " + textOf(psnr, "{:.2f}") + " dB" : "";
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

/// The picture as part of the page; written as a file first, in the folder of the finished frames.
Result<std::string> figure(const Image& image, const std::string& caption,
                           const std::filesystem::path& folder) {
  const auto path = folder / "frame_picture.png";
  VOLUTE_TRY(writeImage(path, image));
  return htmlFigure(path, caption);
}

/// Given, projected and difference of one camera.
Result<std::string> pictureRow(const TomographyView& view, const Image& projected,
                               const Json& camera, const std::filesystem::path& folder) {
  const double exposure = suggestExposure(view.radiance);
  const Image difference = differenceOf(view, projected);
  // A tenth of white, so that rows can be compared at a glance.
  const double scale = 0.1 / exposure;
  VOLUTE_ASSIGN(
      const auto given,
      figure(exposed(view.radiance, exposure),
             fmt::format("{}{}: given", view.name, camera["held_out"] == true ? " (held out)" : ""),
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
  return htmlPictureRow({given, seen, off});
}

/// Values and their standard deviations in the plane from left to right, and up, that holds most.
Result<std::string> errorBarRow(ReconstructedFrames& frames, int index) {
  const VolumeInfo& info = frames.info();
  std::vector<float> values(info.frameValues()), sigma(values.size());
  VOLUTE_TRY(frames.readFrame(index, values));
  VOLUTE_TRY(frames.errorBars().readFrame(index, sigma));
  const auto channels = static_cast<std::size_t>(info.channels);
  const auto sumAt = [&](const std::vector<float>& of, int x, int y, int z) {
    float sum = 0;
    const std::size_t voxel = (static_cast<std::size_t>(z) * info.y + y) * info.x + x;
    for (std::size_t c = 0; c < channels; ++c) sum += of[channels * voxel + c];
    return sum / static_cast<float>(channels);
  };
  int plane = 0;
  double most = -1;
  for (int y = 0; y < info.y; ++y) {
    double sum = 0;
    for (int z = 0; z < info.z; ++z)
      for (int x = 0; x < info.x; ++x) sum += sumAt(values, x, y, z);
    if (sum > most) {
      most = sum;
      plane = y;
    }
  }
  Image value(info.x, info.z, 1), bar(info.x, info.z, 1);
  for (int z = 0; z < info.z; ++z)
    for (int x = 0; x < info.x; ++x) {
      value.at(x, info.z - 1 - z, 0) = sumAt(values, x, plane, z);
      bar.at(x, info.z - 1 - z, 0) = sumAt(sigma, x, plane, z);
    }
  const double top = std::max<double>(*std::ranges::max_element(value.pixels), 1e-30);
  VOLUTE_ASSIGN(const auto first,
                figure(colorMapped(value, ColorMap::kViridis, 0, top),
                       fmt::format("{}, mean of the channels, in the plane of voxels y = {}; 0 "
                                   "(dark) to {:.3g} {} (bright)",
                                   info.name, plane, top, info.unit),
                       frames.work().path()));
  VOLUTE_ASSIGN(const auto second,
                figure(colorMapped(bar, ColorMap::kViridis, 0, top / 2),
                       fmt::format("standard deviation there; bright: half as much, {:.3g} {}",
                                   top / 2, info.unit),
                       frames.work().path()));
  return htmlPictureRow({first, second});
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
    VOLUTE_ASSIGN(const auto volume, frames.emission(index));
    VOLUTE_ASSIGN(const auto views, frames.views(index));
    const Json& record = report["frames"][static_cast<std::size_t>(index)];
    html += fmt::format("<h3>Frame {}</h3>\n", views.frame);
    if (report.contains("uncertainty")) {
      VOLUTE_ASSIGN(const auto bars, errorBarRow(frames, index));
      html += bars;
    }
    for (std::size_t i = 0; i < views.views.size(); ++i) {
      const Image seen =
          asSeenBy(views.views[i], projectVolume(volume, frames.geometry(), frames.info().basis,
                                                 views.views[i].camera,
                                                 report["options"]["rays_per_pixel"].get<int>()));
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
  std::vector<HtmlRow> rows;
  for (const Json& camera : report["cameras"]) {
    rows.push_back({htmlOf(camera["name"]), htmlOf(camera["residual"]),
                    htmlOf(camera["psnr"], "{:.2f}"), htmlOf(camera["gain"]),
                    percentOf(camera["saturated_share"]), camera["held_out"] == true ? "yes" : ""});
  }
  return htmlTable({"camera", "residual", "PSNR [dB]", "gain that fits the others",
                    "saturated pixels", "held out"},
                   rows, HtmlAlign::kNumbers);
}

/// Degrees between the lines of sight, camera by camera.
std::string angleTable(const Json& report) {
  const Json& cameras = report["cameras"];
  HtmlRow head{"degrees, modulo 180"};
  std::vector<HtmlRow> rows;
  std::size_t next = 0;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    head.push_back(htmlOf(cameras[i]["name"]));
    rows.push_back({head.back()});
    for (std::size_t k = 0; k < cameras.size(); ++k)
      rows.back().push_back(k > i ? htmlOf(report["angles"][next++]["degrees"], "{:.1f}") : "");
  }
  return htmlTable(head, rows, HtmlAlign::kNumbers);
}

std::string summary(const Json& report) {
  const Json& psnr = report["held_out_psnr"];
  std::vector<HtmlRow> rows{
      {"residual of the fitted cameras (relative L2)", htmlOf(report["residual"])},
      {"iterations a frame", htmlOf(report["iterations"], "{:.1f}")},
      {"unknown voxels", htmlOf(report["hull_share"]) + " of the volume"},
      {"time a frame", htmlOf(report["seconds_per_frame"], "{:.2f}") + " s"}};
  if (psnr.is_number())
    rows.insert(rows.begin() + 1, {"PSNR of held-out cameras", htmlOf(psnr, "{:.2f}") + " dB"});
  if (report.contains("uncertainty")) {
    rows.push_back({"expected error of the voxels (relative L2)",
                    htmlOf(report["uncertainty"]["expected_error"])});
    rows.push_back(
        {"energy that the pictures leave open", percentOf(report["uncertainty"]["prior_share"])});
  }
  return fmt::format("<p>{} ({}, pixel centres at {}), {} frames, {} voxels.</p>\n",
                     htmlOf(report["capture"]), htmlOf(report["calibration"]),
                     htmlOf(report["pixel_centre"]), report["frames"].size(),
                     htmlOf(report["volume"]["resolution"])) +
         htmlTable({}, rows, HtmlAlign::kNumbers) + htmlWarnings(report["warnings"]) +
         htmlAdvice(report["advice"]);
}

}  // namespace

Status writeReconstructionPage(const std::filesystem::path& target, const Json& report,
                               ReconstructedFrames& frames, Progress& progress) {
  VOLUTE_ASSIGN(const auto shown, pictures(report, frames, progress));
  return writePage(target, "Reconstruction",
                   summary(report) + "<h2>Cameras</h2>\n" + cameraTable(report) + plots(report) +
                       "<h2>Layout</h2>\n" + angleTable(report) + "<h2>Pictures</h2>\n" + shown);
}

}  // namespace volute
