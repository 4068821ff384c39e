// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "volute/base/file_as_written.hpp"
#include "volute/capture/importers.hpp"
#include "volute/capture/json_value.hpp"
#include "volute/io/frame_pattern.hpp"

namespace volute {
namespace {

Result<Distortion> readDistortion(const JsonValue& value) {
  VOLUTE_ASSIGN(const auto k, value.numbers());
  if (k.size() != 4 && k.size() != 5)
    return value.fault("expected the 4 or 5 numbers [k1, k2, p1, p2, k3]");
  return Distortion{k[0], k[1], k[2], k[3], k.size() == 5 ? k[4] : 0};
}

/// "srgb", "gamma:2.2", or {"table": [...]}.
Result<Response> readResponse(const JsonValue& value) {
  if (const auto table = value.find("table")) {
    VOLUTE_ASSIGN(auto values, table->numbers());
    auto response = Response::table(std::move(values));
    return response ? response : Result<Response>(table->fault(response.error().message));
  }
  VOLUTE_ASSIGN(const auto name, value.text());
  auto response = Response::byName(name);
  return response ? response : Result<Response>(value.fault(response.error().message));
}

Result<Measured> readMeasured(const JsonValue& value) {
  VOLUTE_ASSIGN(const auto name, value.text());
  if (name == "absorption")
    return Measured::kAbsorption;
  if (name != "emission")
    return value.fault(fmt::format("is '{}'; expected 'emission' or 'absorption'", name));
  return Measured::kEmission;
}

Result<double> readPositive(const JsonValue& value) {
  VOLUTE_ASSIGN(const double number, value.number());
  if (!(number > 0))
    return value.fault(fmt::format("is {}; expected more than 0", number));
  return number;
}

/// A number, or three, of at least 0 and not all 0.
Result<Rgb> readLight(const JsonValue& value) {
  Rgb light;
  if (value.json().is_number()) {
    VOLUTE_ASSIGN(const double grey, value.number());
    light.setConstant(grey);
  } else {
    VOLUTE_ASSIGN(const Vec3 colour, value.vector());
    light = colour.array();
  }
  if (!(light.minCoeff() >= 0) || !(light.maxCoeff() > 0))
    return value.fault("expected a number above 0, or three of at least 0");
  return light;
}

Result<CaptureLamp> readLamp(const JsonValue& value) {
  CaptureLamp lamp;
  VOLUTE_ASSIGN(const auto kind, value.at("kind"));
  VOLUTE_ASSIGN(const auto name, kind.text());
  if (name != "sun" && name != "point")
    return kind.fault(fmt::format("is '{}'; expected 'sun' or 'point'", name));
  lamp.sun = name == "sun";
  VOLUTE_ASSIGN(const auto place, value.at(lamp.sun ? "direction" : "position"));
  VOLUTE_ASSIGN(const Vec3 vector, place.vector());
  VOLUTE_ASSIGN(const auto light, value.at(lamp.sun ? "radiance" : "intensity"));
  VOLUTE_ASSIGN(lamp.light, readLight(light));
  if (!lamp.sun) {
    lamp.position = vector;
    return lamp;
  }
  if (!(vector.norm() > 0))
    return place.fault("expected the direction in which its light travels");
  lamp.direction = vector.normalized();
  return lamp;
}

/// Reads a number from -most to most.
auto within(double most, const char* unit) {
  return [=](const JsonValue& value) -> Result<double> {
    VOLUTE_ASSIGN(const double number, value.number());
    if (std::abs(number) > most)
      return value.fault(fmt::format("expected -{} to {} {}", most, most, unit));
    return number;
  };
}

/// Bits of the values in files of 16 or 32 bits.
Result<int> readBits(const JsonValue& value) {
  constexpr int kMin = 8, kMax = 32;
  VOLUTE_ASSIGN(const int bits, value.integer());
  if (bits < kMin || bits > kMax)
    return value.fault(fmt::format("is {}; expected {} to {} bits", bits, kMin, kMax));
  return bits;
}

/// A stored value of darkness.
Result<double> readBlack(const JsonValue& value) {
  constexpr double kMax = 0.9;
  VOLUTE_ASSIGN(const double black, value.number());
  if (!(black >= 0 && black <= kMax))
    return value.fault(
        fmt::format("is {:g}; expected 0 to {}: a stored value, 1 = white", black, kMax));
  return black;
}

Result<bool> readFlag(const JsonValue& value) {
  if (!value.json().is_boolean())
    return value.fault("expected true or false");
  return value.json().get<bool>();
}

/// How values are stored, of all cameras or of one.
Status readStoring(const JsonValue& value, PictureSource& pictures) {
  VOLUTE_TRY(readIfThere(value, "color", pictures.response, readResponse));
  VOLUTE_TRY(readIfThere(value, "saturation", pictures.saturation, readPositive));
  VOLUTE_TRY(readIfThere(value, "bits", pictures.bits, readBits));
  VOLUTE_TRY(readIfThere(value, "black", pictures.black, readBlack));
  return readIfThere(value, "bottom_up", pictures.bottomUp, readFlag);
}

Result<double> readRate(const JsonValue& value) {
  constexpr double kMin = 1e-3, kMax = 1e6;
  VOLUTE_ASSIGN(const double rate, value.number());
  if (!(rate >= kMin && rate <= kMax))
    return value.fault(fmt::format("is {}; expected {} to {} pictures a second", rate, kMin, kMax));
  return rate;
}

Result<int> readSide(const JsonValue& value) {
  constexpr int kMax = 1 << 16;
  VOLUTE_ASSIGN(const int side, value.integer());
  if (side < 1 || side > kMax)
    return value.fault(fmt::format("is {}; expected 1 to {} pixels", side, kMax));
  return side;
}

/// Whole numbers, each greater than the one before and none negative.
Result<std::vector<int>> readFrames(const JsonValue& value) {
  VOLUTE_ASSIGN(const auto items, value.items());
  std::vector<int> frames;
  for (const JsonValue& item : items) {
    VOLUTE_ASSIGN(const int frame, item.integer());
    if (frame < 0 || (!frames.empty() && frame <= frames.back()))
      return item.fault("expected frame numbers that ascend from 0 on");
    frames.push_back(frame);
  }
  if (frames.empty())
    return value.fault("expected at least one frame");
  return frames;
}

/// [a, b] is a..b inclusive, longer lists are the frames themselves.
Result<std::vector<int>> readEmptyFrames(const JsonValue& value) {
  VOLUTE_ASSIGN(auto frames, readFrames(value));
  if (frames.size() == 2) {
    constexpr int kMax = 10000;
    if (frames[1] - frames[0] >= kMax)
      return value.fault(fmt::format("more than {} frames", kMax));
    const int last = frames[1];
    frames.pop_back();
    while (frames.back() < last) frames.push_back(frames.back() + 1);
  }
  return frames;
}

/// Reads what a camera of ours may have; the paths in it are relative to the file's folder.
class CameraReader {
 public:
  CameraReader(const JsonValue& value, const std::filesystem::path& folder, FilesAsWritten& written,
               CameraDraft defaults)
      : value_(value), folder_(folder), written_(written), draft_(std::move(defaults)) {
    draft_.where = value.where();
  }

  Result<CameraDraft> read() {
    VOLUTE_TRY(readMember(value_, "name", draft_.name, &JsonValue::text));
    VOLUTE_TRY(readCalibration());
    VOLUTE_TRY(readPictures());
    return draft_;
  }

 private:
  Status readCalibration() {
    Calibration& calibration = draft_.calibration;
    VOLUTE_TRY(readMember(value_, "width", calibration.width, readSide));
    VOLUTE_TRY(readMember(value_, "height", calibration.height, readSide));
    VOLUTE_TRY(readMember(value_, "K", calibration.K, &JsonValue::matrix));
    VOLUTE_TRY(readMember(value_, "R", calibration.R, &JsonValue::matrix));
    VOLUTE_TRY(readMember(value_, "t", calibration.t, &JsonValue::vector));
    return readIfThere(value_, "distortion", calibration.distortion, readDistortion);
  }

  Result<std::string> pathOf(const JsonValue& value) const {
    VOLUTE_ASSIGN(const auto text, value.text());
    if (text.empty())
      return value.fault("expected a file's name");
    if (!namesSeries(text))
      return written_.find(folder_, text).string();
    // No file has a pattern's name, but its folder is there.
    const std::size_t slash = text.find_last_of("/\\");
    if (slash == text.npos)
      return (folder_ / text).string();
    const auto in = written_.find(folder_, text.substr(0, slash));
    std::error_code error;
    return (std::filesystem::is_directory(in, error) ? in / text.substr(slash + 1) : folder_ / text)
        .string();
  }

  Status readPictures() {
    PictureSource& pictures = draft_.pictures;
    if (const auto image = value_.find("image")) {
      VOLUTE_ASSIGN(pictures.image, pathOf(*image));
      if (namesSeries(pictures.image) && !FramePattern::parse(pictures.image)) {
        return image->fault("expected one frame number in the file's name, as %04d, %d or ####");
      }
    }
    if (const auto video = value_.find("video")) {
      VOLUTE_ASSIGN(pictures.video, pathOf(*video));
      if (!pictures.image.empty())
        return video->fault("the camera has an image too; expected one of them");
    }
    VOLUTE_TRY(readIfThere(value_, "video_start", pictures.videoStart, within(1e9, "frames")));
    if (const auto start = value_.find("start_time")) {
      if (value_.find("video_start"))
        return start->fault("the camera has video_start too; expected one of them");
      VOLUTE_ASSIGN(draft_.startTime, within(1e9, "seconds")(*start));
    }
    VOLUTE_TRY(readIfThere(value_, "frames_per_second", draft_.framesPerSecond, readRate));
    VOLUTE_TRY(readIfThere(value_, "frame_shift", pictures.frameShift, within(1000000, "frames")));
    if (const auto error = value_.find("reprojection_error")) {
      constexpr double kMax = 20;
      VOLUTE_ASSIGN(draft_.reprojectionError, error->number());
      if (!(draft_.reprojectionError >= 0 && draft_.reprojectionError <= kMax))
        return error->fault(fmt::format("expected 0 to {} pixels", kMax));
    }
    const auto path = [this](const JsonValue& value) { return pathOf(value); };
    VOLUTE_TRY(readIfThere(value_, "background", pictures.background, path));
    VOLUTE_TRY(readIfThere(value_, "dark", pictures.dark, path));
    VOLUTE_TRY(readIfThere(value_, "mask", pictures.mask, path));
    if (const auto gain = value_.find("gain"); gain && gain->json().is_array()) {
      VOLUTE_ASSIGN(pictures.channelGain, readLight(*gain));
      if (!(pictures.channelGain.minCoeff() > 0))
        return gain->fault("expected a number above 0, or three");
    } else if (gain) {
      VOLUTE_ASSIGN(pictures.gain, readPositive(*gain));
    }
    VOLUTE_TRY(readIfThere(value_, "gain_by_frame", pictures.gainByFrame, readFlag));
    if (const auto exposure = value_.find("exposure")) {
      VOLUTE_ASSIGN(pictures.exposure, readPositive(*exposure));
    }
    if (const auto exponent = value_.find("exponent")) {
      constexpr double kMin = 0.1, kMax = 10;
      VOLUTE_ASSIGN(pictures.exponent, exponent->number());
      if (!(pictures.exponent >= kMin && pictures.exponent <= kMax))
        return exponent->fault(
            fmt::format("is {}; expected {} to {}", pictures.exponent, kMin, kMax));
    }
    return readStoring(value_, pictures);
  }

  const JsonValue& value_;
  const std::filesystem::path& folder_;
  FilesAsWritten& written_;
  CameraDraft draft_;
};

void remarkUnknown(const JsonValue& value, std::initializer_list<std::string_view> known,
                   CaptureDraft& draft) {
  for (const auto& key : value.unknownKeys(known))
    draft.remarks.emplace_back(RemarkCode::kLeftOut,
                               fmt::format("{} is not known and ignored", key));
}

/// Of an object that is a curve.
void remarkUnknownOfColor(const JsonValue& value, CaptureDraft& draft) {
  if (const auto color = value.find("color"))
    remarkUnknown(*color, {"table"}, draft);
}

void remarkUnknownOfLamp(const JsonValue& lamp, CaptureDraft& draft) {
  if (draft.lighting.lamps.back().sun)
    remarkUnknown(lamp, {"kind", "direction", "radiance"}, draft);
  else
    remarkUnknown(lamp, {"kind", "position", "intensity"}, draft);
}

void remarkUnknownOfSpectrum(const JsonValue& spectrum, CaptureDraft& draft) {
  if (spectrum.find("lines")) {
    remarkUnknown(spectrum, {"lines", "scale", "soot_exponent"}, draft);
    return;
  }
  remarkUnknown(spectrum,
                {"sensitivities", "wavelengths", "black_body", "radiance_scale", "soot_exponent"},
                draft);
  if (const auto body = spectrum.find("black_body"))
    remarkUnknown(*body, {"temperature", "radiance"}, draft);
}

/// A background that is given counts before empty frames.
void remarkOnBackgrounds(CaptureDraft& draft) {
  std::vector<std::string> names;
  for (const CameraDraft& camera : draft.cameras) {
    if (!draft.emptyFrames.empty() && !camera.pictures.background.empty())
      names.push_back(camera.name);
  }
  if (!names.empty())
    draft.remarks.emplace_back(
        RemarkCode::kLeftOut,
        fmt::format("camera{} {}: \"background\" counts, and \"empty_frames\" are not read",
                    names.size() > 1 ? "s" : "", fmt::join(names, ", ")));
}

Status readVolume(const JsonValue& value, CaptureDraft& draft) {
  VOLUTE_ASSIGN(const auto low, value.at("min"));
  VOLUTE_ASSIGN(const auto high, value.at("max"));
  Box3 bounds;
  VOLUTE_ASSIGN(bounds.min, low.vector());
  VOLUTE_ASSIGN(bounds.max, high.vector());
  if (bounds.empty())
    return value.fault("min is not below max on every axis");
  draft.bounds = bounds;
  VOLUTE_ASSIGN(const auto resolution, value.at("resolution"));
  VOLUTE_ASSIGN(const auto sides, resolution.items());
  if (sides.size() != 3)
    return resolution.fault("expected three whole numbers, voxels on x, y and z");
  std::array<int, 3> voxels{};
  for (int axis = 0; axis < 3; ++axis) {
    constexpr int kMax = 1 << 14;
    VOLUTE_ASSIGN(voxels[axis], sides[axis].integer());
    if (voxels[axis] < 1 || voxels[axis] > kMax)
      return sides[axis].fault(fmt::format("expected 1 to {} voxels", kMax));
  }
  draft.resolution = voxels;
  return {};
}

/// What stands before the cameras.
Status readHead(const JsonValue& root, CaptureDraft& draft, CameraDraft& defaults) {
  if (const auto centre = root.find("pixel_centre")) {
    VOLUTE_ASSIGN(draft.pixelCentre, centre->number());
    if (draft.pixelCentre != 0 && draft.pixelCentre != 0.5)
      return centre->fault("expected 0.5 or 0: where the centre of the first pixel is");
  }
  defaults.calibration.pixelCentre = draft.pixelCentre;
  VOLUTE_TRY(readIfThere(root, "kind", draft.measured, readMeasured));
  VOLUTE_TRY(readStoring(root, defaults.pictures));
  VOLUTE_TRY(readIfThere(root, "white", draft.white, readPositive));
  VOLUTE_TRY(readIfThere(root, "noise_sigma", draft.noiseSigma, readPositive));
  VOLUTE_TRY(readIfThere(root, "frames_per_second", draft.framesPerSecond, readRate));
  VOLUTE_TRY(readIfThere(root, "frames", draft.frames, readFrames));
  VOLUTE_TRY(readIfThere(root, "empty_frames", draft.emptyFrames, readEmptyFrames));
  if (const auto lamps = root.find("lamps")) {
    VOLUTE_ASSIGN(const auto items, lamps->items());
    for (const JsonValue& item : items) {
      VOLUTE_ASSIGN(const auto lamp, readLamp(item));
      draft.lighting.lamps.push_back(lamp);
      remarkUnknownOfLamp(item, draft);
    }
  }
  if (const auto albedo = root.find("albedo")) {
    VOLUTE_ASSIGN(draft.lighting.albedo, readLight(*albedo));
    if (draft.lighting.albedo.maxCoeff() > 1)
      return albedo->fault("expected 0 to 1");
  }
  if (const auto volume = root.find("volume")) {
    VOLUTE_TRY(readVolume(*volume, draft));
    remarkUnknown(*volume, {"min", "max", "resolution"}, draft);
  }
  return {};
}

}  // namespace

Result<CaptureDraft> readCaptureJson(const std::filesystem::path& file,
                                     const nlohmann::json& json) {
  const JsonValue root(json, file.string());
  VOLUTE_ASSIGN(const auto format, root.at("format"));
  VOLUTE_ASSIGN(const auto name, format.text());
  if (name != "volute-capture-1")
    return format.fault(fmt::format("is '{}'; expected 'volute-capture-1'", name));
  CaptureDraft draft;
  draft.kind = "capture.json";
  CameraDraft defaults;
  VOLUTE_TRY(readHead(root, draft, defaults));
  remarkUnknown(root,
                {"format", "kind", "color", "white", "pixel_centre", "frames", "volume",
                 "noise_sigma", "cameras", "empty_frames", "saturation", "bits", "black",
                 "frames_per_second", "lamps", "albedo", "spectrum", "bottom_up"},
                draft);
  remarkUnknownOfColor(root, draft);
  if (const auto spectrum = root.find("spectrum")) {
    VOLUTE_ASSIGN(draft.spectrum, readSpectrum(*spectrum, file.parent_path(), draft.remarks));
    remarkUnknownOfSpectrum(*spectrum, draft);
  }
  VOLUTE_ASSIGN(const auto list, root.at("cameras"));
  VOLUTE_ASSIGN(const auto cameras, list.items());
  const auto folder = file.parent_path();
  FilesAsWritten written;
  for (const JsonValue& camera : cameras) {
    VOLUTE_ASSIGN(auto read, CameraReader(camera, folder, written, defaults).read());
    draft.cameras.push_back(std::move(read));
    remarkUnknown(camera,
                  {"name",
                   "image",
                   "width",
                   "height",
                   "K",
                   "R",
                   "t",
                   "distortion",
                   "background",
                   "dark",
                   "mask",
                   "gain",
                   "exposure",
                   "exponent",
                   "reprojection_error",
                   "video",
                   "video_start",
                   "start_time",
                   "frames_per_second",
                   "frame_shift",
                   "color",
                   "saturation",
                   "bits",
                   "black",
                   "bottom_up",
                   "gain_by_frame"},
                  draft);
    remarkUnknownOfColor(camera, draft);
  }
  remarkOnBackgrounds(draft);
  if (std::string remark = written.remark(); !remark.empty())
    draft.remarks.emplace_back(RemarkCode::kAssumed, std::move(remark));
  return draft;
}

}  // namespace volute
