// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/capture/capture_report.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "volute/capture/image_name.hpp"
#include "volute/capture/open_capture.hpp"

namespace volute {
namespace {

using OrderedJson = nlohmann::ordered_json;

/// How many of the chosen frames a camera has pictures of; a film counts where it is there.
std::size_t picturesThere(const CaptureCamera& camera, const std::vector<int>& frames) {
  std::error_code ignored;
  if (camera.pictures.image.empty())
    return std::filesystem::exists(camera.pictures.video, ignored) ? frames.size() : 0;
  return static_cast<std::size_t>(std::ranges::count_if(frames, [&](int frame) {
    const PicturePlace place = camera.pictures.placeOf(frame);
    return camera.pictures.isThere(place.number) &&
           (place.share == 0 || camera.pictures.isThere(place.number + 1));
  }));
}

/// What a camera's pictures are compared with, and how they are read, as far as it is stated.
std::string readingText(const CaptureCamera& camera, bool& missing) {
  const PictureSource& pictures = camera.pictures;
  std::error_code ignored;
  std::string text;
  for (const auto& [what, file] :
       {std::pair("background", &pictures.background), std::pair("dark", &pictures.dark),
        std::pair("mask", &pictures.mask)}) {
    if (file->empty())
      continue;
    const bool there = std::filesystem::exists(*file, ignored);
    missing = missing || !there;
    text += fmt::format(", {} {}{}", what, file->filename().string(), there ? "" : " is MISSING");
  }
  const auto add = [&](std::string_view what, double value, double usual) {
    if (value != usual)
      text += fmt::format(", {} {:g}", what, value);
  };
  if (pictures.response)
    text += ", " + pictures.response->name();
  add("exposure", pictures.exposure, 1);
  add("gain", pictures.gain, 1);
  if (pictures.gainByFrame)
    text += ", a gain by frame";
  if ((pictures.channelGain != 1).any())
    text += ", gains " + vectorText(Vec3(pictures.channelGain.matrix()));
  add("exponent", pictures.exponent, 1);
  add("black", pictures.black, 0);
  add("bits", pictures.bits, 0);
  if (pictures.saturation)
    text += fmt::format(", saturated from {:g}", *pictures.saturation);
  add("pictures a frame:", pictures.rate, 1);
  add("starts with frame", pictures.videoStart, 0);
  add("frame shift", pictures.frameShift, 0);
  return text;
}

void addCameras(Report& report, const Capture& capture, bool& damaged) {
  OrderedJson list = OrderedJson::array();
  std::string text;
  for (const CaptureCamera& camera : capture.cameras) {
    const std::size_t there = picturesThere(camera, capture.frames);
    const std::filesystem::path source = camera.pictures.image.empty()
                                             ? camera.pictures.video
                                             : std::filesystem::path(camera.pictures.image);
    const auto folder = std::filesystem::path(capture.file).parent_path();
    const std::string pictures =
        source.empty() ? "" : source.lexically_proximate(folder.empty() ? "." : folder).string();
    const bool missing = there < capture.frames.size();
    bool lacks = false;
    const std::string reading = readingText(camera, lacks);
    damaged = damaged || missing || lacks;
    list.push_back({{"name", camera.name},
                    {"size", {camera.camera.width(), camera.camera.height()}},
                    {"eye", vectorJson(camera.camera.eye())},
                    {"pictures", pictures},
                    {"pictures_there", there}});
    for (const auto& [what, file] :
         {std::pair("background", &camera.pictures.background),
          std::pair("dark", &camera.pictures.dark), std::pair("mask", &camera.pictures.mask)}) {
      if (!file->empty())
        list.back()[what] = file->string();
    }
    text +=
        fmt::format("\n  {}: {} x {} pixels from {} m, {}{}{}", camera.name, camera.camera.width(),
                    camera.camera.height(), vectorText(camera.camera.eye()),
                    pictures.empty() ? "no pictures" : pictures,
                    missing ? fmt::format(": {} of {} pictures are MISSING",
                                          capture.frames.size() - there, capture.frames.size())
                            : "",
                    reading);
  }
  report.add("cameras", list, text);
}

}  // namespace

Result<FileDescription> describeCapture(const std::string& path, std::uint64_t maxMemory) {
  CaptureOptions options;
  options.maxMemory = maxMemory;
  auto capture = openCapture(path, options);
  std::string missing;
  FileDescription described;
  if (!capture) {
    missing = capture.error().message;
    // The volume and the names of the pictures may be given to a reconstruction.
    described.damaged =
        capture.error().code != ErrorCode::kInvalidArgument || capture.error().hints.empty();
    CaptureOptions anyVolume = options;
    anyVolume.bounds = Box3(Vec3(0, 0, 0), Vec3(1, 1, 1));
    anyVolume.resolution = {1, 1, 1};
    auto rest = openCapture(path, anyVolume);
    if (rest)
      rest->volume = {};
    else
      rest = openCalibration(path, options);  // which may be whole alone
    if (!rest)
      return tl::unexpected(std::move(capture.error()));
    capture = std::move(rest);
  }
  Report& report = described.report;
  report.add("file", path).add("kind", "capture").add("format", capture->kind);
  report.add("measures", capture->measured == Measured::kAbsorption ? "absorption" : "emission");
  addCameras(report, *capture, described.damaged);
  const auto& frames = capture->frames;
  if (!frames.empty()) {
    report.add("frames", frames.size(), fmt::format("{}", frames.size()))
        .add("frame_numbers", {frames.front(), frames.back()},
             fmt::format("{} to {}", frames.front(), frames.back()));
  }
  const auto& [x, y, z] = capture->volume.resolution;
  if (x > 0) {
    report.add("size", {x, y, z}, fmt::format("{} x {} x {} voxels", x, y, z))
        .add("bounds", boxJson(capture->volume.bounds), boxText(capture->volume.bounds));
  }
  if (!missing.empty())
    report.add("missing", missing);
  std::string remarks;
  OrderedJson list = OrderedJson::array();
  for (const Remark& remark : capture->remarks) {
    remarks += "\n  " + remark.sentence;
    list.push_back({{"code", remarkName(remark.code)},
                    {"sentence", remark.sentence},
                    {"file", remark.file},
                    {"place", remark.place}});
  }
  report.add("remarks", list, remarks);
  return described;
}

}  // namespace volute
