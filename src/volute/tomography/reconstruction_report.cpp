// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/reconstruction_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "volute/report/json.hpp"
#include "volute/tomography/layout.hpp"

namespace volute {
namespace {

Json jsonOf(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

/// The mean of a number that frames or cameras have; those without it do not count.
Json meanOf(const std::vector<Json>& values) {
  double sum = 0;
  int count = 0;
  for (const Json& value : values) {
    if (!value.is_number())
      continue;
    sum += value.get<double>();
    ++count;
  }
  return count > 0 ? jsonNumber(sum / count) : Json();
}

Json camerasJson(const Capture& capture, const Json& frames) {
  Json cameras = Json::array();
  for (std::size_t i = 0; i < capture.cameras.size(); ++i) {
    std::vector<Json> residuals, psnrs, gains, saturated;
    for (const Json& frame : frames) {
      const Json& camera = frame["cameras"][i];
      residuals.push_back(camera["residual"]);
      psnrs.push_back(camera["psnr"]);
      saturated.push_back(camera["saturated_share"]);
      if (camera.contains("gain"))
        gains.push_back(camera["gain"]);
    }
    const CaptureCamera& known = capture.cameras[i];
    cameras.push_back({{"name", known.name},
                       {"width", known.camera.width()},
                       {"height", known.camera.height()},
                       {"eye", jsonOf(known.camera.eye())},
                       {"held_out", frames.front()["cameras"][i]["held_out"]},
                       {"residual", meanOf(residuals)},
                       {"psnr", meanOf(psnrs)},
                       {"gain", meanOf(gains)},
                       {"saturated_share", meanOf(saturated)}});
  }
  return cameras;
}

Json anglesJson(const CameraLayout& layout) {
  Json angles = Json::array();
  for (const SightAngle& pair : layout.angles)
    angles.push_back(
        {{"cameras", {layout.names[pair.a], layout.names[pair.b]}}, {"degrees", pair.degrees}});
  return angles;
}

/// Over the cameras that were held out.
Json heldOutPsnr(const Json& cameras) {
  std::vector<Json> values;
  for (const Json& camera : cameras) {
    if (camera["held_out"] == true)
      values.push_back(camera["psnr"]);
  }
  return meanOf(values);
}

Json residualOfFitted(const Json& cameras) {
  std::vector<Json> values;
  for (const Json& camera : cameras) {
    if (camera["held_out"] == false)
      values.push_back(camera["residual"]);
  }
  return meanOf(values);
}

}  // namespace

Json settingsJson(const ReconstructionSettings& settings) {
  const TomographyOptions& options = settings.tomography;
  const auto optional = [](const auto& value) { return value ? Json(*value) : Json(); };
  return {{"basis", options.basis == Basis::kBox ? "box" : "trilinear"},
          {"solver", tomographySolverName(options.solver)},
          {"iterations", optional(options.iterations)},
          {"regularization", regularizationName(options.regularization)},
          {"lambda", optional(options.lambda)},
          {"sparsity", optional(options.sparsity)},
          {"rays_per_pixel", options.raysPerPixel},
          {"hull", options.hull},
          {"coarse_to_fine", options.coarseToFine},
          {"warm_start", settings.warmStart},
          {"temporal", options.temporal},
          {"noise_sigma", optional(options.noiseSigma)},
          {"lighting", settings.singleScattering ? "single-scattering" : "constant"},
          {"error_bars", settings.errorBars},
          {"flame", settings.flame},
          {"max_saturated", settings.limits.saturated},
          {"force", settings.force}};
}

Result<Json> reconstructionReport(const CaptureRefinement& refinement,
                                  const ReconstructionSettings& settings,
                                  const ReconstructedFrames& frames,
                                  const VelocityFrames* velocity) {
  const Capture& capture = refinement.capture;
  Json records = Json::array(), warnings = Json::array();
  std::vector<Json> iterations, seconds, hulls, expected, prior;
  const CameraLayout layout(capture);
  const auto advice = layout.advice();
  for (int i = 0; i < frames.info().frames; ++i) {
    VOLUTE_ASSIGN(auto record, frames.record(i));
    for (const Json& warning : record["warnings"]) warnings.push_back(warning);
    iterations.push_back(record["iterations"]);
    seconds.push_back(record["seconds"]);
    hulls.push_back(record["hull_share"]);
    if (record.contains("uncertainty")) {
      expected.push_back(record["uncertainty"]["expected_error"]);
      prior.push_back(record["uncertainty"]["prior_share"]);
    }
    records.push_back(std::move(record));
  }
  for (const std::string& text : refinement.faults) warnings.push_back(text);
  for (const std::string& text : refinement.pictureFaults) warnings.push_back(text);
  for (const std::string& text : outstandingCorrections(refinement)) warnings.push_back(text);
  Json remarks = Json::array();
  for (const Remark& remark : capture.remarks)
    remarks.push_back({{"code", remarkName(remark.code)}, {"sentence", remark.sentence}});
  const Json cameras = camerasJson(capture, records);
  const CaptureVolume& volume = capture.volume;
  Json json = {{"format", "volute-reconstruction-report-1"},
               {"capture", capture.file.string()},
               {"calibration", capture.kind},
               {"capture_remarks", remarks},
               {"pixel_centre", capture.pixelCentre},
               {"volume",
                {{"min", jsonOf(volume.bounds.min)},
                 {"max", jsonOf(volume.bounds.max)},
                 {"resolution", volume.resolution}}},
               {"options", settingsJson(settings)},
               {"residual", residualOfFitted(cameras)},
               {"held_out_psnr", heldOutPsnr(cameras)},
               {"iterations", meanOf(iterations)},
               {"hull_share", meanOf(hulls)},
               {"seconds_per_frame", meanOf(seconds)},
               {"cameras", cameras},
               {"angles", anglesJson(layout)},
               {"advice", advice ? Json(advice->sentence) : Json()},
               {"warnings", warnings},
               {"frames", records}};
  if (velocity) {
    VOLUTE_ASSIGN(json["velocity"], velocity->json());
  }
  if (settings.errorBars)
    json["uncertainty"] = {{"expected_error", meanOf(expected)}, {"prior_share", meanOf(prior)}};
  json["refinement"] = refinementJson(refinement);
  return json;
}

Status addResidualOfFile(ReconstructedFrames& frames, FrameSource& written, Json& json,
                         Progress& progress) {
  constexpr int kMax = 8;
  constexpr double kClearly = 1.1, kAtLeast = 2e-3;
  const int count = frames.info().frames, looked = std::min(count, kMax);
  std::vector<float> values(frames.info().frameValues());
  double before = 0, after = 0;
  for (int i = 0; i < looked; ++i) {
    if (progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped: comparing the file with the pictures");
    const int index = i * count / looked;
    VOLUTE_TRY(frames.readFrame(index, values));
    VOLUTE_ASSIGN(const double solved, frames.residualOf(index, values));
    VOLUTE_TRY(written.readFrame(index, values));
    VOLUTE_ASSIGN(const double stored, frames.residualOf(index, values));
    before += solved / looked;
    after += stored / looked;
  }
  json["file_residual"] = jsonNumber(after);
  if (after > kClearly * before && after > before + kAtLeast) {
    const auto text = fmt::format(
        "the compressed file leaves {:.1f} % of the pictures unexplained, the volumes before "
        "compression {:.1f} %; a smaller error of the file keeps more",
        100 * after, 100 * before);
    json["warnings"].push_back(text);
    progress.remark({RemarkCode::kDoubtful, "warning: " + text});
  }
  return {};
}

void addSummary(const nlohmann::ordered_json& json, Report& report) {
  const auto number = [&](const char* key, const char* format) {
    if (json[key].is_number())
      report.add(key, json[key], fmt::format(fmt::runtime(format), json[key].get<double>()));
  };
  number("held_out_psnr", "{:.2f} dB");
  number("residual", "{:.4g} (relative L2 of the fitted cameras: how well they are repeated)");
  if (json.contains("file_residual"))
    number("file_residual", "{:.4g} (the same of the file as it was compressed)");
  if (json.contains("uncertainty")) {
    const auto& known = json["uncertainty"];
    report
        .add("expected_error", known["expected_error"],
             fmt::format("{:.3g} (relative L2 of the voxels, as their standard deviations have it)",
                         known["expected_error"].get<double>()))
        .add("prior_share", known["prior_share"],
             fmt::format("{:.2g} % of the energy is left open by the pictures",
                         100 * known["prior_share"].get<double>()));
  }
  number("iterations", "{:.1f} a frame");
  number("hull_share", "{:.4g} of the volume");
  number("seconds_per_frame", "{:.2f} s");
  std::vector<std::string> residuals;
  nlohmann::ordered_json byName = nlohmann::ordered_json::object();
  for (const auto& camera : json["cameras"]) {
    const auto name = camera["name"].get<std::string>();
    byName[name] = camera["residual"];
    if (camera["residual"].is_number())
      residuals.push_back(fmt::format("{} {:.3f}", name, camera["residual"].get<double>()));
  }
  report.add("residuals", byName, fmt::format("{}", fmt::join(residuals, ", ")));
  report.add("warnings", json["warnings"], fmt::format("{}", json["warnings"].size()));
}

}  // namespace volute
