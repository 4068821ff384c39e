// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/capture/write_capture.hpp"

#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "volute/base/write_file.hpp"

namespace volute {
namespace {

using Json = nlohmann::ordered_json;

Json jsonOf(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

Json jsonOf(const Mat3& m) {
  Json rows = Json::array();
  for (int row = 0; row < 3; ++row) rows.push_back({m(row, 0), m(row, 1), m(row, 2)});
  return rows;
}

Json jsonOf(const Response& response) {
  if (response.kind() != Response::Kind::kTable)
    return response.name();
  return {{"table", response.table()}};
}

Json lampJson(const CaptureLamp& lamp) {
  const Vec3 light = lamp.light.matrix();
  if (lamp.sun)
    return {{"kind", "sun"}, {"direction", jsonOf(lamp.direction)}, {"radiance", jsonOf(light)}};
  return {{"kind", "point"}, {"position", jsonOf(lamp.position)}, {"intensity", jsonOf(light)}};
}

/// Whole numbers without a point.
Json numberOf(double value) {
  return value == std::floor(value) ? Json(static_cast<std::int64_t>(value)) : Json(value);
}

/// As rows that the reader takes for the same lines: each its own width.
Json spectrumJson(const CaptureSpectrum& spectrum) {
  Json json{{"lines", Json::array()}};
  for (const auto& line : spectrum.lines)
    json["lines"].push_back({line.wavelength, line.weight[0], line.weight[1], line.weight[2]});
  json["scale"] = jsonOf(Vec3(spectrum.scale.matrix()));
  json["soot_exponent"] = spectrum.sootExponent;
  return json;
}

Json cameraJson(const CaptureCamera& known, double framesPerSecond,
                const std::filesystem::path& folder) {
  const Camera& camera = known.camera;
  const PictureSource& pictures = known.pictures;
  const auto path = [&](const std::filesystem::path& file) {
    std::error_code error;
    // Absolute first: proximate() keeps a relative path whose first part is no file, as patterns.
    const auto near = std::filesystem::proximate(std::filesystem::absolute(file), folder, error);
    return (error ? std::filesystem::absolute(file) : near).string();
  };
  Json json{{"name", known.name}};
  if (pictures.video.empty()) {
    json["image"] = path(pictures.image);
  } else {
    json["video"] = path(pictures.video);
    json["video_start"] = numberOf(pictures.videoStart);
  }
  if (pictures.video.empty() && pictures.videoStart != 0)
    json["start_time"] = pictures.videoStart / framesPerSecond;
  if (pictures.rate != 1)
    json["frames_per_second"] = pictures.rate * framesPerSecond;
  if (pictures.frameShift != 0)
    json["frame_shift"] = numberOf(pictures.frameShift);
  json["width"] = camera.width();
  json["height"] = camera.height();
  json["K"] = jsonOf(camera.intrinsics());
  json["R"] = jsonOf(camera.rotation());
  json["t"] = jsonOf(Vec3(-camera.rotation() * camera.eye()));
  if (const Distortion& lens = camera.distortion(); !lens.none())
    json["distortion"] = {lens.k1, lens.k2, lens.p1, lens.p2, lens.k3};
  if (known.reprojectionError > 0)
    json["reprojection_error"] = known.reprojectionError;
  if (!pictures.background.empty())
    json["background"] = path(pictures.background);
  if (!pictures.dark.empty())
    json["dark"] = path(pictures.dark);
  if (!pictures.mask.empty())
    json["mask"] = path(pictures.mask);
  if ((pictures.channelGain != 1).any())
    json["gain"] = jsonOf(Vec3((pictures.gain * pictures.channelGain).matrix()));
  else if (pictures.gain != 1)
    json["gain"] = pictures.gain;
  if (pictures.gainByFrame)
    json["gain_by_frame"] = true;
  if (pictures.exposure != 1)
    json["exposure"] = pictures.exposure;
  if (pictures.exponent != 1)
    json["exponent"] = pictures.exponent;
  if (pictures.response)
    json["color"] = jsonOf(*pictures.response);
  if (pictures.saturation)
    json["saturation"] = *pictures.saturation;
  if (pictures.bits != 0)
    json["bits"] = pictures.bits;
  if (pictures.black != 0)
    json["black"] = pictures.black;
  if (pictures.bottomUp)
    json["bottom_up"] = true;
  return json;
}

}  // namespace

Status writeCapture(const std::filesystem::path& file, const Capture& capture) {
  for (const CaptureCamera& known : capture.cameras) {
    if (known.camera.isOrthographic())
      return fail(ErrorCode::kInvalidArgument,
                  "{}: camera {} is orthographic, which capture.json has no words for",
                  file.string(), known.name);
  }
  Json json{{"format", "volute-capture-1"}, {"white", capture.white}, {"pixel_centre", 0.5}};
  if (capture.measured == Measured::kAbsorption)
    json["kind"] = "absorption";
  json["frames_per_second"] = capture.framesPerSecond;
  if (!capture.statedFrames.empty())
    json["frames"] = capture.statedFrames;  // also those that were not chosen
  json["volume"] = {{"min", jsonOf(capture.volume.bounds.min)},
                    {"max", jsonOf(capture.volume.bounds.max)},
                    {"resolution", capture.volume.resolution}};
  if (capture.noiseSigma)
    json["noise_sigma"] = *capture.noiseSigma;
  if (!capture.emptyFrames.empty())
    json["empty_frames"] = capture.emptyFrames;  // two are neighbours, so that they are a range too
  if (!capture.lighting.lamps.empty()) {
    json["lamps"] = Json::array();
    for (const CaptureLamp& lamp : capture.lighting.lamps) json["lamps"].push_back(lampJson(lamp));
    json["albedo"] = jsonOf(Vec3(capture.lighting.albedo.matrix()));
  }
  if (capture.spectrum.stated())
    json["spectrum"] = spectrumJson(capture.spectrum);
  json["cameras"] = Json::array();
  const auto folder = std::filesystem::absolute(file).parent_path();
  for (const CaptureCamera& known : capture.cameras)
    json["cameras"].push_back(cameraJson(known, capture.framesPerSecond, folder));
  return writeFile(file.string(), json.dump(1) + "\n");
}

}  // namespace volute
