// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/run_key.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "volute/base/version.hpp"
#include "volute/tomography/reconstruction_report.hpp"

namespace volute {
namespace {

std::string stateOf(const std::filesystem::path& file) {
  std::error_code error;
  const auto size = std::filesystem::file_size(file, error);
  const auto time = std::filesystem::last_write_time(file, error).time_since_epoch().count();
  return fmt::format("{} {} {}\n", file.string(), error ? 0 : size, time);
}

std::string digits(const auto& matrix) {
  std::string text;
  for (Eigen::Index i = 0; i < matrix.size(); ++i) text += fmt::format("{} ", *(matrix.data() + i));
  return text;
}

std::string describe(const CaptureCamera& known) {
  const Camera& camera = known.camera;
  const PictureSource& pictures = known.pictures;
  const Distortion& lens = camera.distortion();
  std::string text =
      fmt::format("{} {} {} {} {} {} {} {} {} {} {} {} {} {} {} {}\n", known.name, camera.width(),
                  camera.height(), digits(camera.intrinsics()), digits(camera.rotation()),
                  digits(camera.eye()), lens.k1, lens.k2, lens.p1, lens.p2, lens.k3, pictures.gain,
                  pictures.videoStart, pictures.frameShift, pictures.saturation.value_or(-1),
                  pictures.response ? pictures.response->name() : "as the pictures state");
  text += digits(pictures.channelGain) + fmt::format("exposure {} ", pictures.exposure);
  text +=
      fmt::format("{} pictures a frame, exponent {}, error {}, {} bits, black {}\n", pictures.rate,
                  pictures.exponent, known.reprojectionError, pictures.bits, pictures.black);
  if (pictures.bottomUp)
    text += "bottom up\n";
  if (pictures.gainByFrame)
    text += "a gain by frame\n";
  // A table's name does not tell its values.
  for (int i = 0; pictures.response && i <= 64; ++i)
    text += fmt::format("{} ", pictures.response->linear(i / 64.0));
  for (const auto& file : {pictures.background, pictures.dark, pictures.mask, pictures.video}) {
    if (!file.empty())
      text += stateOf(file);
  }
  return text;
}

}  // namespace

std::vector<std::string> frameKeys(const Capture& capture, const ReconstructionSettings& settings,
                                   const std::vector<std::string>& heldOut) {
  std::string text =
      fmt::format("{} {} {} {} {} {}\n", VOLUTE_VERSION, settingsJson(settings).dump(),
                  digits(capture.volume.bounds.min), digits(capture.volume.bounds.max),
                  fmt::join(capture.volume.resolution, " "), capture.white);
  text +=
      fmt::format("{} {}\n", capture.measured == Measured::kAbsorption, fmt::join(heldOut, "/"));
  // Of depths the noise of light tells what is dark.
  text += fmt::format("noise {}, empty {}\n", capture.noiseSigma.value_or(0),
                      fmt::join(capture.emptyFrames, " "));
  for (const CaptureCamera& camera : capture.cameras) {
    text += describe(camera);
    PictureSource unshifted = camera.pictures;
    unshifted.frameShift = 0;  // as empty frames are read
    for (const int frame : capture.emptyFrames)
      text += stateOf(unshifted.fileOf(unshifted.placeOf(frame).number));
  }
  if (settings.singleScattering) {
    for (const CaptureLamp& lamp : capture.lighting.lamps)
      text += fmt::format("lamp {} {} {} {}\n", lamp.sun, digits(lamp.direction),
                          digits(lamp.position), digits(lamp.light));
    text += fmt::format("albedo {}\n", digits(capture.lighting.albedo));
  }
  for (const auto& line : capture.spectrum.lines)
    text += fmt::format("line {} {}\n", line.wavelength, digits(line.weight));
  if (capture.spectrum.stated())
    text +=
        fmt::format("scale {} {}\n", digits(capture.spectrum.scale), capture.spectrum.sootExponent);
  const std::string common = digestOf(text);
  std::vector<std::string> keys;
  const auto begins = chainBegins(capture.frames, settings.warmStart);
  for (const int frame : capture.frames) {
    const bool begin = std::ranges::binary_search(begins, static_cast<int>(keys.size()));
    std::string own = common + (begin ? "" : keys.back());
    for (const CaptureCamera& camera : capture.cameras) {
      const PicturePlace place = camera.pictures.placeOf(frame);
      own += stateOf(camera.pictures.fileOf(place.number));
      if (place.share > 0)
        own += stateOf(camera.pictures.fileOf(place.number + 1));
      const auto& leftOut = camera.pictures.leftOut;
      if (std::ranges::find(leftOut, frame) != leftOut.end())
        own += "left out\n";
      if (camera.pictures.pages > 1)  // all of one file
        own += fmt::format("page {:.6f}\n", place.number + place.share);
    }
    keys.push_back(digestOf(own));
  }
  return keys;
}

}  // namespace volute
