// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <span>

#include "volute/capture/importers.hpp"
#include "volute/capture/json_value.hpp"

namespace volute {
namespace {

/// A value of the frame itself, or else of the whole file.
std::optional<JsonValue> findIn(const JsonValue& frame, const JsonValue& root,
                                std::string_view key) {
  const auto own = frame.find(key);
  return own ? own : root.find(key);
}

Result<double> numberIn(const JsonValue& frame, const JsonValue& root, std::string_view key,
                        double initial) {
  const auto value = findIn(frame, root, key);
  if (!value)
    return initial;
  return value->number();
}

/// Other lenses than ours, as the tools mark them.
Status checkLensMarks(const JsonValue& frame, const JsonValue& root) {
  for (const char* key : {"is_fisheye", "latlong", "equirectangular", "orthographic"}) {
    const auto mark = findIn(frame, root, key);
    if (mark && mark->json() != false && mark->json() != 0) {
      return mark->fault(
          "lenses of this kind are not read; expected a pinhole with k1, k2, k3, p1, p2: undistort "
          "the pictures, and write the calibration of what comes out");
    }
  }
  if (const auto ftheta = findIn(frame, root, "ftheta_p0"))
    return ftheta->fault("f-theta lenses are not read; undistort the pictures");
  return {};
}

Status checkModel(const JsonValue& frame, const JsonValue& root) {
  VOLUTE_TRY(checkLensMarks(frame, root));
  const auto model = findIn(frame, root, "camera_model");
  if (model) {
    VOLUTE_ASSIGN(const auto name, model->text());
    constexpr std::array<std::string_view, 5> kKnown{"PINHOLE", "SIMPLE_PINHOLE", "SIMPLE_RADIAL",
                                                     "RADIAL", "OPENCV"};
    if (std::ranges::find(kKnown, name) == kKnown.end()) {
      return model->fault(fmt::format("the camera model {} is not read; expected {}", name,
                                      fmt::join(kKnown, ", ")));
    }
  }
  for (const char* key : {"k4", "k5", "k6"}) {
    VOLUTE_ASSIGN(const double value, numberIn(frame, root, key, 0));
    if (value != 0)
      return frame.fault(
          fmt::format("{} is {}; lenses with k1, k2, k3, p1, p2 are read", key, value));
  }
  return {};
}

Status readIntrinsics(const JsonValue& frame, const JsonValue& root, Calibration& calibration) {
  for (const auto& [key, side] :
       {std::pair("w", &calibration.width), std::pair("h", &calibration.height)}) {
    if (const auto value = findIn(frame, root, key)) {
      VOLUTE_ASSIGN(*side, value->integer());
      if (*side < 1)
        return value->fault("expected a number of pixels");
    }
  }
  const double width = calibration.width, height = calibration.height;
  VOLUTE_ASSIGN(const double angleX, numberIn(frame, root, "camera_angle_x", 0));
  VOLUTE_ASSIGN(const double angleY, numberIn(frame, root, "camera_angle_y", 0));
  const double byAngle = angleX > 0 ? 0.5 * width / std::tan(0.5 * angleX) : 0;
  auto& K = calibration.K;
  VOLUTE_ASSIGN(K(0, 0), numberIn(frame, root, "fl_x", byAngle));
  const double byAngleY =
      angleY > 0 && height > 0 ? 0.5 * height / std::tan(0.5 * angleY) : K(0, 0);
  VOLUTE_ASSIGN(K(1, 1), numberIn(frame, root, "fl_y", byAngleY));
  VOLUTE_ASSIGN(K(0, 2), numberIn(frame, root, "cx", 0.5 * width));
  VOLUTE_ASSIGN(K(1, 2), numberIn(frame, root, "cy", 0.5 * height));
  if (K(0, 0) == 0)
    return frame.fault("has no focal length; expected fl_x, or camera_angle_x with w");
  if (width == 0 && !(findIn(frame, root, "cx") && findIn(frame, root, "cy")))
    return frame.fault("has neither cx, cy nor w, h; expected one of them");
  Distortion& lens = calibration.distortion;
  for (const auto& [key, value] :
       {std::pair("k1", &lens.k1), std::pair("k2", &lens.k2), std::pair("p1", &lens.p1),
        std::pair("p2", &lens.p2), std::pair("k3", &lens.k3)}) {
    VOLUTE_ASSIGN(*value, numberIn(frame, root, key, 0));
  }
  return {};
}

Status readPose(const JsonValue& frame, Calibration& calibration) {
  VOLUTE_ASSIGN(const auto value, frame.at("transform_matrix"));
  const int rows = value.json().is_array() && value.json().size() == 3 ? 3 : 4;
  VOLUTE_ASSIGN(const auto toWorld, value.matrix(rows, 4));
  const Mat3 axes = toWorld.topLeftCorner(3, 3);
  const Vec3 eye = toWorld.block(0, 3, 3, 1);
  // From OpenGL's camera axes (y up, z backward) to ours (y down, z forward).
  calibration.R = Vec3(1, -1, -1).asDiagonal() * axes.transpose();
  calibration.t = -calibration.R * eye;
  return {};
}

/// Keys of whole files and of their frames that say nothing that matters here, or that are read.
const std::initializer_list<std::string_view> kKnown{
    "frames", "camera_model", "camera_angle_x", "camera_angle_y", "fl_x", "fl_y", "cx", "cy", "w",
    "h", "k1", "k2", "k3", "k4", "k5", "k6", "p1", "p2", "is_fisheye", "latlong", "equirectangular",
    "orthographic", "file_path", "transform_matrix",
    // of the tools that write them: names, where to train and what to show
    "aabb_scale", "aabb", "render_aabb", "scale", "offset", "up", "from_na", "sharpness",
    "rotation", "colmap_im_id", "applied_transform", "applied_scale", "orientation_override",
    "train_filenames", "val_filenames", "test_filenames", "ply_file_path", "depth_file_path",
    "enable_depth_loading", "integer_depth_scale", "depth_unit_scale_factor",
    "n_extra_learnable_dims", "auxiliary_data"};

/// A remark for each key that is not known, however many entries have it.
void remarkUnknown(const JsonValue& root, std::span<const JsonValue> frames, CaptureDraft& draft) {
  for (const auto& key : root.unknownKeys(kKnown))
    draft.remarks.push_back(fmt::format("{} is not known and ignored", key));
  std::map<std::string, std::pair<std::string, int>> found;  // by key: the first place, how many
  for (const JsonValue& frame : frames) {
    for (const auto& path : frame.unknownKeys(kKnown)) {
      auto& [first, count] = found[path.substr(path.rfind('.') + 1)];
      if (count++ == 0)
        first = path;
    }
  }
  for (const auto& [key, place] : found) {
    draft.remarks.push_back(fmt::format(
        "{} is not known and ignored{}", place.first,
        place.second > 1 ? fmt::format(", as in {} more entries", place.second - 1) : ""));
  }
}

/// "train/r_0" means train/r_0.png.
std::string withExtension(const std::filesystem::path& path) {
  return path.has_extension() ? path.string() : path.string() + ".png";
}

}  // namespace

Result<CaptureDraft> readNerfTransforms(const std::filesystem::path& file,
                                        const nlohmann::json& json) {
  const JsonValue root(json, file.string());
  CaptureDraft draft;
  draft.kind = "NeRF transforms";
  VOLUTE_ASSIGN(const auto list, root.at("frames"));
  VOLUTE_ASSIGN(const auto frames, list.items());
  for (const JsonValue& frame : frames) {
    CameraDraft camera;
    camera.where = frame.where();
    VOLUTE_TRY(checkModel(frame, root));
    VOLUTE_TRY(readIntrinsics(frame, root, camera.calibration));
    VOLUTE_TRY(readPose(frame, camera.calibration));
    VOLUTE_ASSIGN(const auto path, frame.at("file_path"));
    VOLUTE_ASSIGN(camera.pictureName, path.text());
    camera.pictures.image =
        withExtension((file.parent_path() / camera.pictureName).lexically_normal());
    draft.cameras.push_back(std::move(camera));
  }
  remarkUnknown(root, frames, draft);
  return draft;
}

}  // namespace volute
