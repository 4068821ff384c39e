// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <span>
#include <tuple>

#include "volute/base/file_as_written.hpp"
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

/// An angle of view [radians]; 0 where it is not stated.
Result<double> angleIn(const JsonValue& frame, const JsonValue& root, std::string_view key) {
  const auto value = findIn(frame, root, key);
  if (!value)
    return 0.0;
  VOLUTE_ASSIGN(const double angle, value->number());
  if (angle >= 0 && angle < std::numbers::pi)
    return angle;
  constexpr double kHalfTurn = 180;
  return value->fault(fmt::format(
      "is {:g}; expected an angle of view in radians, from 0 to below {:.4f}{}", angle,
      std::numbers::pi,
      angle > 0 && angle < kHalfTurn
          ? fmt::format(": {:g} degrees are {:.6g}", angle, angle * std::numbers::pi / kHalfTurn)
          : std::string()));
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

/// Coefficients that the model that is named does not have.
void remarkOnModel(const JsonValue& frame, const JsonValue& root, const Distortion& lens,
                   CaptureDraft& draft) {
  const auto model = findIn(frame, root, "camera_model");
  if (!model)
    return;
  const auto name = model->json().get<std::string>();  // which checkModel() knows
  const bool radial = name == "RADIAL", oneRadial = name == "SIMPLE_RADIAL";
  if (name == "OPENCV")
    return;
  for (const auto& [key, value, has] :
       {std::tuple("k1", lens.k1, radial || oneRadial), std::tuple("k2", lens.k2, radial),
        std::tuple("k3", lens.k3, false), std::tuple("p1", lens.p1, false),
        std::tuple("p2", lens.p2, false)}) {
    if (value == 0 || has)
      continue;
    draft.remarks.emplace_back(
        RemarkCode::kDoubtful,
        fmt::format("the camera model {} has no {}, which is {:g} and is applied: are the pictures "
                    "undistorted?",
                    name, key, value));
    return;
  }
}

Status readIntrinsics(const JsonValue& frame, const JsonValue& root, CameraDraft& camera) {
  Calibration& calibration = camera.calibration;
  for (const auto& [key, side] :
       {std::pair("w", &calibration.width), std::pair("h", &calibration.height)}) {
    if (const auto value = findIn(frame, root, key)) {
      VOLUTE_ASSIGN(*side, value->integer());
      if (*side < 1)
        return value->fault("expected a number of pixels");
    }
  }
  const double width = calibration.width, height = calibration.height;
  VOLUTE_ASSIGN(const double angleX, angleIn(frame, root, "camera_angle_x"));
  VOLUTE_ASSIGN(const double angleY, angleIn(frame, root, "camera_angle_y"));
  const double byAngle = angleX > 0 ? 0.5 * width / std::tan(0.5 * angleX) : 0;
  const double byAngleY = angleY > 0 ? 0.5 * height / std::tan(0.5 * angleY) : 0;
  camera.angles = {angleX, angleY};
  camera.centred = {width == 0 && !findIn(frame, root, "cx"),
                    height == 0 && !findIn(frame, root, "cy")};
  auto& K = calibration.K;
  VOLUTE_ASSIGN(K(0, 0), numberIn(frame, root, "fl_x", byAngle));
  VOLUTE_ASSIGN(K(1, 1), numberIn(frame, root, "fl_y", angleY > 0 ? byAngleY : K(0, 0)));
  for (const JsonValue& one : {frame, root}) {  // an entry's own counts before the file's
    constexpr double kSame = 0.05;
    for (const auto& [axis, stated, said, side] :
         {std::tuple('x', K(0, 0), byAngle, 'w'), std::tuple('y', K(1, 1), byAngleY, 'h')}) {
      const std::string focal = fmt::format("fl_{}", axis),
                        angle = fmt::format("camera_angle_{}", axis);
      if (said > 0 && one.find(focal) && one.find(angle) && std::abs(stated / said - 1) > kSame)
        return one.fault(
            fmt::format("{} is {:.6g}, and {} with {} says {:.6g} pixels; expected one focal "
                        "length: leave out what is wrong",
                        focal, stated, angle, side, said));
    }
  }
  VOLUTE_ASSIGN(K(0, 2), numberIn(frame, root, "cx", 0.5 * width));
  VOLUTE_ASSIGN(K(1, 2), numberIn(frame, root, "cy", 0.5 * height));
  if (K(0, 0) == 0 && (angleX == 0 || width > 0 || findIn(frame, root, "fl_x")))
    return frame.fault("has no focal length; expected fl_x or camera_angle_x");
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
  VOLUTE_ASSIGN(const Mat4 toWorld, value.affine());
  constexpr double kRounding = 1e-6;
  if ((toWorld.row(3) - Vec4(0, 0, 0, 1)).norm() > kRounding) {
    return value.fault(
        "its last row is not 0, 0, 0, 1; expected rows of the matrix from camera to world: is it "
        "written by columns?");
  }
  const Mat3 axes = linearPart(toWorld);
  const Vec3 eye = offsetPart(toWorld);
  // From OpenGL's camera axes (y up, z backward) to ours (y down, z forward).
  calibration.R = Vec3(1, -1, -1).asDiagonal() * axes.transpose();
  calibration.t = -(calibration.R * eye);
  return {};
}

/// Keys of whole files and of their frames that say nothing that matters here, or that are read.
const std::initializer_list<std::string_view> kKnown{
    "frames", "camera_model", "camera_angle_x", "camera_angle_y", "fl_x", "fl_y", "cx", "cy", "w",
    "h", "k1", "k2", "k3", "k4", "k5", "k6", "p1", "p2", "is_fisheye", "latlong", "equirectangular",
    "orthographic", "file_path", "transform_matrix", "time", "applied_transform", "applied_scale",
    "scale", "offset",
    // of the tools that write them: names, where to train and what to show
    "aabb_scale", "aabb", "render_aabb", "up", "from_na", "sharpness", "rotation", "colmap_im_id",
    "orientation_override", "train_filenames", "val_filenames", "test_filenames", "ply_file_path",
    "depth_file_path", "enable_depth_loading", "integer_depth_scale", "depth_unit_scale_factor",
    "n_extra_learnable_dims", "auxiliary_data"};

/// A remark for each key that is not known, however many entries have it.
void remarkUnknown(const JsonValue& root, std::span<const JsonValue> frames, CaptureDraft& draft) {
  for (const auto& key : root.unknownKeys(kKnown))
    draft.remarks.emplace_back(RemarkCode::kLeftOut,
                               fmt::format("{} is not known and ignored", key));
  std::map<std::string, std::pair<std::string, int>> found;  // by key: the first place, how many
  for (const JsonValue& frame : frames) {
    for (const auto& path : frame.unknownKeys(kKnown)) {
      auto& [first, count] = found[path.substr(path.rfind('.') + 1)];
      if (count++ == 0)
        first = path;
    }
  }
  for (const auto& [key, place] : found) {
    draft.remarks.emplace_back(
        RemarkCode::kLeftOut,
        fmt::format(
            "{} is not known and ignored{}", place.first,
            place.second > 1 ? fmt::format(", as in {} more entries", place.second - 1) : ""));
  }
}

/// What tools did to the positions, or would have a reader do: lengths are then not metres, and the
/// axes not those that were measured.
Status remarkFrameOfReference(const JsonValue& root, CaptureDraft& draft) {
  bool scaled = false;
  if (const auto applied = root.find("applied_scale")) {
    VOLUTE_ASSIGN(const double scale, applied->number());
    if (!(scale > 0))
      return applied->fault(fmt::format("is {:g}; expected a factor above 0", scale));
    scaled = scale != 1;
    if (scaled) {
      draft.remarks.emplace_back(
          RemarkCode::kAssumed,
          fmt::format("positions were scaled by {:g} from what was measured (\"applied_scale\"); "
                      "lengths are not metres: bounds are in these units, and values per unit of "
                      "length are {:g} times those per unit that was measured",
                      scale, 1 / scale));
    }
  }
  if (const auto applied = root.find("applied_transform")) {
    VOLUTE_ASSIGN(const Mat4 moved, applied->affine());
    if (!linearPart(moved).isApprox(Mat3::Identity()) || !offsetPart(moved).isZero())
      draft.remarks.emplace_back(
          RemarkCode::kAssumed,
          "positions were turned or moved from what was measured (\"applied_transform\"); bounds "
          "are "
          "in the turned axes");
  }
  const auto scale = root.find("scale"), offset = root.find("offset");
  if ((scale && scale->json() != 1) ||
      (offset && offset->json() != nlohmann::json::array({0, 0, 0}))) {
    draft.remarks.emplace_back(
        RemarkCode::kLeftOut,
        "\"scale\" and \"offset\" place the cameras in a viewer's cube and are not applied; bounds "
        "are in the units of transform_matrix");
  }
  if (!scaled)
    draft.remarks.emplace_back(
        RemarkCode::kNote,
        "lengths of transform_matrix are taken as metres; the format has no unit");
  for (const char* box : {"aabb", "render_aabb"}) {
    if (root.find(box))
      draft.remarks.emplace_back(
          RemarkCode::kLeftOut,
          fmt::format("\"{}\" is a box of the tool that wrote it, and not the bounds", box));
  }
  return {};
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
  FilesAsWritten written;
  for (const JsonValue& frame : frames) {
    CameraDraft camera;
    camera.where = frame.where();
    VOLUTE_TRY(checkModel(frame, root));
    VOLUTE_TRY(readIntrinsics(frame, root, camera));
    if (draft.cameras.empty())  // stands for the others
      remarkOnModel(frame, root, camera.calibration.distortion, draft);
    VOLUTE_TRY(readPose(frame, camera.calibration));
    VOLUTE_TRY(readMember(frame, "file_path", camera.pictureName, &JsonValue::text));
    camera.pictures.image =
        written.find(file.parent_path(), withExtension(camera.pictureName)).lexically_normal();
    if (camera.pictures.image.find('\\') == std::string::npos)
      std::ranges::replace(camera.pictureName, '\\', '/');
    VOLUTE_TRY(readIfThere(frame, "time", camera.time, &JsonValue::number));
    draft.cameras.push_back(std::move(camera));
  }
  if (std::string remark = written.remark(); !remark.empty())
    draft.remarks.emplace_back(RemarkCode::kAssumed, std::move(remark));
  VOLUTE_TRY(remarkFrameOfReference(root, draft));
  remarkUnknown(root, frames, draft);
  return draft;
}

namespace {

/// The box of a unit cube, scaled and placed; remarked on where it does not lie along the axes.
Status readVoxelBox(const JsonValue& root, CaptureDraft& draft) {
  const auto matrix = root.find("voxel_matrix"), scale = root.find("voxel_scale");
  if (!matrix || !scale)
    return {};
  VOLUTE_ASSIGN(const auto placed, matrix->affine());
  VOLUTE_ASSIGN(const Vec3 sides, scale->vector());
  if (!(sides.minCoeff() > 0))
    return scale->fault("expected three lengths above 0");
  Box3 bounds;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 at(corner & 1 ? sides.x() : 0, corner & 2 ? sides.y() : 0,
                  corner & 4 ? sides.z() : 0);
    bounds.extend(Vec3(linearPart(placed) * at + offsetPart(placed)));
  }
  constexpr double kGrown = 1.01;
  if (bounds.size().prod() > kGrown * sides.prod())
    draft.remarks.emplace_back(
        RemarkCode::kChanged,
        "voxel_matrix turns the volume: its bounds are those of the box around it, along the axes");
  draft.bounds = bounds;
  return {};
}

Result<CameraDraft> readFilmedCamera(const JsonValue& value, const std::filesystem::path& folder) {
  CameraDraft camera;
  camera.where = value.where();
  VOLUTE_ASSIGN(const auto name, value.at("file_name"));
  VOLUTE_ASSIGN(const std::string film, name.text());
  camera.name = std::filesystem::path(film).stem().string();
  camera.pictures.video = (folder / film).lexically_normal();
  VOLUTE_ASSIGN(const auto size, value.at("camera_hw"));
  VOLUTE_ASSIGN(const auto sides, size.numbers(2));
  if (!(sides[0] >= 1 && sides[1] >= 1 && sides[0] <= 65536 && sides[1] <= 65536))
    return size.fault("expected height and width in pixels");
  Calibration& calibration = camera.calibration;
  calibration.height = static_cast<int>(sides[0]);
  calibration.width = static_cast<int>(sides[1]);
  VOLUTE_ASSIGN(const double angle, angleIn(value, value, "camera_angle_x"));
  if (!(angle > 0))
    return value.fault("has no camera_angle_x; expected the angle of view over its width");
  VOLUTE_ASSIGN(const double angleY, angleIn(value, value, "camera_angle_y"));
  const double focal = 0.5 * calibration.width / std::tan(0.5 * angle);
  const double focalY = angleY > 0 ? 0.5 * calibration.height / std::tan(0.5 * angleY) : focal;
  calibration.K =
      Mat3(focal, 0, 0.5 * calibration.width, 0, focalY, 0.5 * calibration.height, 0, 0, 1);
  VOLUTE_TRY(readPose(value, calibration));
  if (const auto rate = value.find("frame_rate")) {
    VOLUTE_ASSIGN(camera.framesPerSecond, rate->number());
    if (!(*camera.framesPerSecond > 0))
      return rate->fault("expected pictures in a second, more than 0");
  }
  VOLUTE_TRY(readIfThere(value, "frame_num", camera.filmLength, &JsonValue::integer));
  return camera;
}

}  // namespace

Result<CaptureDraft> readFilmedFluid(const std::filesystem::path& file,
                                     const nlohmann::json& json) {
  const JsonValue root(json, file.string());
  CaptureDraft draft;
  draft.kind = "filmed fluid";
  for (const char* list : {"train_videos", "test_videos"}) {
    const auto videos = root.find(list);
    if (!videos)
      continue;
    VOLUTE_ASSIGN(const auto items, videos->items());
    for (const JsonValue& item : items) {
      VOLUTE_ASSIGN(auto camera, readFilmedCamera(item, file.parent_path()));
      if (!draft.framesPerSecond)
        draft.framesPerSecond = camera.framesPerSecond;
      if (std::string_view(list) == "test_videos")
        draft.remarks.push_back(fmt::format(
            "camera {} is there to be compared with (test_videos): hold it out for that",
            camera.name));
      for (const auto& key :
           item.unknownKeys({"file_name", "camera_hw", "camera_angle_x", "camera_angle_y",
                             "transform_matrix", "frame_rate", "frame_num"}))
        draft.remarks.emplace_back(RemarkCode::kLeftOut,
                                   fmt::format("{} is not known and ignored", key));
      draft.cameras.push_back(std::move(camera));
    }
  }
  // The last five are a path of views to show, and what lies along their rays.
  for (const auto& key :
       root.unknownKeys({"train_videos", "test_videos", "voxel_matrix", "voxel_scale",
                         "frame_bkg_color", "near", "far", "phi", "rot", "render_center"}))
    draft.remarks.emplace_back(RemarkCode::kLeftOut,
                               fmt::format("{} is not known and ignored", key));
  VOLUTE_TRY(readVoxelBox(root, draft));
  if (const auto colour = root.find("frame_bkg_color")) {
    VOLUTE_ASSIGN(const Vec3 background, colour->vector());
    if (background.maxCoeff() > 0)
      draft.remarks.emplace_back(
          RemarkCode::kLeftOut,
          "frame_bkg_color is not black and not subtracted; state a background in a capture.json");
  }
  return draft;
}

}  // namespace volute
