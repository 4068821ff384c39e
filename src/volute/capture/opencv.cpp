// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <tuple>
#include <unordered_set>

#include "volute/capture/importers.hpp"
#include "volute/capture/opencv_storage.hpp"
#include "volute/math/rotation.hpp"

namespace volute {
namespace {

/// In which of our matrices' names a camera's name stands after what.
constexpr std::array<std::string_view, 18> kPrefixes{"fisheye_model",
                                                     "K_",
                                                     "M_",
                                                     "camera_matrix_",
                                                     "D_",
                                                     "distortion_coefficients_",
                                                     "dist_coeffs_",
                                                     "R_",
                                                     "rvec_",
                                                     "T_",
                                                     "t_",
                                                     "tvec_",
                                                     "image_width_",
                                                     "width_",
                                                     "image_height_",
                                                     "height_",
                                                     "image_width",
                                                     "image_height"};

/// Whether the name is that of a camera's matrix.
bool isOurs(std::string_view name) {
  return std::ranges::any_of(kPrefixes, [&](std::string_view prefix) {
    return prefix.ends_with('_') && name.starts_with(prefix) && name.size() > prefix.size();
  });
}

/// Cameras with a pose, and no lens: one of their names has a slip in it, or is cut off.
Status checkPoses(const OpenCvStorage& entries, const std::string& file) {
  const auto has = [&](std::initializer_list<const char*> prefixes, const std::string& name) {
    return std::ranges::any_of(
        prefixes, [&](const char* prefix) { return entries.find(prefix + name) != nullptr; });
  };
  for (const auto& [key, entry] : entries) {
    for (const std::string_view prefix : {"R_", "rvec_"}) {
      const std::string name = key.starts_with(prefix) ? key.substr(prefix.size()) : "";
      if (name.empty() || !has({"T_", "t_", "tvec_"}, name) ||
          has({"K_", "M_", "camera_matrix_"}, name))
        continue;
      return fail(ErrorCode::kInvalidData,
                  "{}: camera {} has a pose ({}) and no matrix K_{}; expected both: is a name "
                  "misspelt, or the file cut off?",
                  file, name, key, name);
    }
  }
  return {};
}

/// What no camera uses: another calibration's matrices, or a name with a slip in it.
std::vector<std::string> unused(const OpenCvStorage& entries,
                                std::span<const CameraDraft> cameras) {
  std::vector<std::string> names;
  std::unordered_set<std::string> cameraNames;
  for (const CameraDraft& camera : cameras) cameraNames.insert(camera.name);
  for (const auto& [name, entry] : entries) {
    const bool used = std::ranges::any_of(kPrefixes, [&](std::string_view prefix) {
      if (!name.starts_with(prefix))
        return false;
      const std::string rest = name.substr(prefix.size());
      return (rest.empty() && prefix.back() != '_') || cameraNames.contains(rest);
    });
    if (!used)
      names.push_back(name);
  }
  names.insert(names.end(), entries.others.begin(), entries.others.end());
  return names;
}

class CameraFinder {
 public:
  CameraFinder(const OpenCvStorage& entries, std::string file)
      : entries_(entries), file_(std::move(file)) {}

  Result<CameraDraft> read(const std::string& name) const {
    CameraDraft camera;
    camera.name = name;
    camera.where = fmt::format("{}: camera {}", file_, name);
    Calibration& calibration = camera.calibration;
    calibration.pixelCentre = 0;
    VOLUTE_ASSIGN(const OpenCvMatrix K, matrix({"K_", "M_", "camera_matrix_"}, name, 3, 3));
    calibration.K = toMatrix(K);
    VOLUTE_ASSIGN(calibration.distortion, distortion(name));
    VOLUTE_ASSIGN(calibration.R, rotation(name));
    VOLUTE_ASSIGN(const OpenCvMatrix t, matrix({"T_", "t_", "tvec_"}, name, 3, 1));
    calibration.t = Vec3(t.values[0], t.values[1], t.values[2]);
    VOLUTE_TRY(readSize(name, calibration));
    return camera;
  }

 private:
  /// One of several names of the same thing; null: none is there.
  Result<const OpenCvMatrix*> find(std::initializer_list<const char*> prefixes,
                                   const std::string& name) const {
    const OpenCvMatrix* found = nullptr;
    const char* first = nullptr;
    for (const char* prefix : prefixes) {
      const OpenCvMatrix* entry = entries_.find(prefix + name);
      if (entry && found)
        return fail(ErrorCode::kInvalidData,
                    "{}: camera {} has both {}{} and {}{}; expected one of them", file_, name,
                    first, name, prefix, name);
      if (entry)
        found = entry, first = prefix;
    }
    return found;
  }

  Result<OpenCvMatrix> matrix(std::initializer_list<const char*> prefixes, const std::string& name,
                              int rows, int columns) const {
    VOLUTE_ASSIGN(const OpenCvMatrix* entry, find(prefixes, name));
    const std::string wanted = *prefixes.begin() + name;
    if (!entry)
      return fail(ErrorCode::kNotFound, "{}: there is no matrix {}", file_, wanted);
    const bool fits = (entry->rows == rows && entry->columns == columns) ||
                      (columns == 1 && entry->rows == 1 && entry->columns == rows);
    if (!fits || entry->values.size() != static_cast<std::size_t>(rows) * columns) {
      return fail(ErrorCode::kInvalidData, "{}: {} is {} x {} with {} values; expected {} x {}",
                  file_, wanted, entry->rows, entry->columns, entry->values.size(), rows, columns);
    }
    return *entry;
  }

  static Mat3 toMatrix(const OpenCvMatrix& entry) {
    Mat3 matrix;
    for (int i = 0; i < 9; ++i) matrix(i / 3, i % 3) = entry.values[static_cast<std::size_t>(i)];
    return matrix;
  }

  Result<Distortion> distortion(const std::string& name) const {
    VOLUTE_ASSIGN(const OpenCvMatrix* entry,
                  find({"D_", "distortion_coefficients_", "dist_coeffs_"}, name));
    if (!entry)
      return Distortion{};
    auto k = entry->values;
    for (std::size_t i = 5; i < k.size(); ++i) {
      if (k[i] != 0) {
        return fail(ErrorCode::kUnsupported,
                    "{}: D_{} has {} coefficients; lenses with k1, k2, p1, p2, k3 are read", file_,
                    name, k.size());
      }
    }
    if (!k.empty() && k.size() < 4) {
      return fail(ErrorCode::kInvalidData,
                  "{}: D_{} has {} coefficients; expected k1, k2, p1, p2 and perhaps k3", file_,
                  name, k.size());
    }
    k.resize(5, 0);
    return Distortion{k[0], k[1], k[2], k[3], k[4]};
  }

  /// A matrix, or Rodrigues' vector: the axis times the angle.
  Result<Mat3> rotation(const std::string& name) const {
    VOLUTE_ASSIGN(const OpenCvMatrix* entry, find({"R_", "rvec_"}, name));
    if (entry && entry->values.size() == 3) {
      const Vec3 axis(entry->values[0], entry->values[1], entry->values[2]);
      if (!(axis.norm() <= 2 * std::numbers::pi))
        return fail(
            ErrorCode::kInvalidData,
            "{}: camera {} is turned by {:.4g} radians; expected Rodrigues' vector, an axis "
            "times its angle in radians: is it in degrees, or are these three angles?",
            file_, name, axis.norm());
      if (axis.norm() == 0)
        return Mat3::Identity();
      return turnAbout(axis.normalized(), axis.norm());
    }
    VOLUTE_ASSIGN(const OpenCvMatrix R, matrix({"R_", "rvec_"}, name, 3, 3));
    return toMatrix(R);
  }

  Status readSize(const std::string& name, Calibration& calibration) const {
    VOLUTE_ASSIGN(const OpenCvMatrix* width, find({"image_width_", "width_"}, name));
    VOLUTE_ASSIGN(const OpenCvMatrix* height, find({"image_height_", "height_"}, name));
    width = width ? width : entries_.find("image_width");
    height = height ? height : entries_.find("image_height");
    constexpr double kMax = 1 << 20;
    for (const auto& [entry, side, what] : {std::tuple(width, &calibration.width, "width"),
                                            std::tuple(height, &calibration.height, "height")}) {
      if (!entry)
        continue;
      const double value = entry->values.empty() ? 0 : entry->values[0];
      if (entry->values.size() != 1 || !(value >= 1 && value <= kMax) || value != std::floor(value))
        return fail(ErrorCode::kInvalidData,
                    "{}: camera {}: the {} of its pictures is {}; expected a number of pixels",
                    file_, name, what, value);
      *side = static_cast<int>(value);
    }
    return {};
  }

  const OpenCvStorage& entries_;
  std::string file_;
};

OpenCvMatrix identity() {
  return {3, 3, {1, 0, 0, 0, 1, 0, 0, 0, 1}};
}

/// Of several names the one that is there.
const OpenCvMatrix* anyOf(const OpenCvStorage& entries, std::initializer_list<const char*> names) {
  for (const char* name : names) {
    if (const OpenCvMatrix* entry = entries.find(name))
      return entry;
  }
  return nullptr;
}

/// A file of the same folder and ending, e.g. "extrinsics" beside intrinsics.yml.
Result<std::optional<OpenCvStorage>> sibling(const std::filesystem::path& file, const char* name) {
  auto other = file;
  other.replace_filename(name + file.extension().string());
  std::error_code error;
  if (other == file || !std::filesystem::exists(other, error))
    return std::nullopt;
  VOLUTE_ASSIGN(auto entries, readOpenCvStorage(other, isOurs));
  return entries;
}

/// What OpenCV's stereo sample writes: M1, D1, M2, D2 in intrinsics.yml, and R and T from the first
/// camera to the second in extrinsics.yml, or all in one file; as cameras 1 and 2, the world that
/// of the first. Nothing for other files.
Result<std::optional<OpenCvStorage>> stereoEntries(const OpenCvStorage& entries,
                                                   const std::filesystem::path& file) {
  const auto matrix = [](const OpenCvStorage& of, int camera) {
    return camera == 1 ? anyOf(of, {"M1", "cameraMatrix1", "K1"})
                       : anyOf(of, {"M2", "cameraMatrix2", "K2"});
  };
  const bool pose = entries.find("R") && entries.find("T");
  const bool lenses = matrix(entries, 1) && matrix(entries, 2);
  if (!pose && !lenses)
    return std::nullopt;
  std::optional<OpenCvStorage> other;
  if (!pose || !lenses) {
    VOLUTE_ASSIGN(other, sibling(file, pose ? "intrinsics" : "extrinsics"));
  }
  const OpenCvStorage& poses = pose || !other ? entries : *other;
  const OpenCvStorage& cameras = lenses || !other ? entries : *other;
  if (!poses.find("R") || !poses.find("T") || !matrix(cameras, 1) || !matrix(cameras, 2))
    return fail(ErrorCode::kInvalidData,
                "{}: a stereo calibration without {}; expected {}{} beside it, or all in one file",
                file.string(), pose ? "M1 and M2" : "R and T", pose ? "intrinsics" : "extrinsics",
                file.extension().string());
  OpenCvStorage named;
  for (const int camera : {1, 2}) {
    const std::string name = std::to_string(camera);
    named.add("K_" + name, *matrix(cameras, camera));
    const OpenCvMatrix* lens =
        camera == 1 ? anyOf(cameras, {"D1", "distCoeffs1"}) : anyOf(cameras, {"D2", "distCoeffs2"});
    if (lens)
      named.add("D_" + name, *lens);
    named.add("R_" + name, camera == 1 ? identity() : *poses.find("R"));
    named.add("T_" + name, camera == 1 ? OpenCvMatrix{3, 1, {0, 0, 0}} : *poses.find("T"));
  }
  for (const char* size : {"image_width", "image_height"}) {
    if (const OpenCvMatrix* entry = entries.find(size))
      named.add(size, *entry);
  }
  return named;
}

/// What OpenCV's calibration sample writes of one camera: camera_matrix, distortion_coefficients
/// and a row of extrinsic_parameters for each view of the board.
bool isSample(const OpenCvStorage& entries) {
  return entries.find("camera_matrix") && entries.find("extrinsic_parameters");
}

/// Such files of one folder and ending are cameras by the files' names, in the world of the board
/// in their first view.
/// @param unread  gets why files of the folder cannot be read
Result<OpenCvStorage> sampleEntries(const std::filesystem::path& file,
                                    std::vector<std::string>& unread) {
  std::vector<std::filesystem::path> files;
  std::error_code error;
  const auto folder = file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
  for (const auto& other : std::filesystem::directory_iterator(folder, error)) {
    if (other.path().extension() == file.extension())
      files.push_back(other.path());
  }
  std::ranges::sort(files);
  OpenCvStorage named;
  for (const auto& other : files) {
    const auto entries = readOpenCvStorage(other, isOurs);
    if (!entries && other.filename() == file.filename())
      return entries;
    if (!entries)
      unread.push_back(entries.error().message);
    if (!entries || !isSample(*entries))
      continue;
    const std::string name = other.stem().string();
    const OpenCvMatrix& poses = *entries->find("extrinsic_parameters");
    if (poses.columns != 6 || poses.rows < 1 || poses.values.size() < 6)
      return fail(ErrorCode::kInvalidData,
                  "{}: extrinsic_parameters is {} x {}; expected rows of six numbers: a rotation "
                  "vector and a translation",
                  other.string(), poses.rows, poses.columns);
    named.add("K_" + name, *entries->find("camera_matrix"));
    if (const OpenCvMatrix* lens = entries->find("distortion_coefficients"))
      named.add("D_" + name, *lens);
    const auto& v = poses.values;
    named.add("rvec_" + name, {3, 1, {v[0], v[1], v[2]}});
    named.add("T_" + name, {3, 1, {v[3], v[4], v[5]}});
    for (const char* size : {"image_width", "image_height"}) {
      if (const OpenCvMatrix* entry = entries->find(size))
        named.add(size + ("_" + name), *entry);
    }
    const OpenCvMatrix* fisheye = entries->find("fisheye_model");
    if (fisheye && fisheye->values != std::vector<double>{0})
      named.add("fisheye_model", *fisheye);
  }
  return named;
}

}  // namespace

Result<CaptureDraft> readOpenCv(const std::filesystem::path& file) {
  VOLUTE_ASSIGN(auto entries, readOpenCvStorage(file, isOurs));
  const char* world = nullptr;
  std::vector<std::string> unread;
  if (isSample(entries)) {
    VOLUTE_ASSIGN(entries, sampleEntries(file, unread));
    world =
        "cameras are the files of OpenCV's calibration sample in this folder, in the world of "
        "the board in the first view of each, which must be the same board; lengths are the "
        "board's";
  } else {
    VOLUTE_ASSIGN(auto stereo, stereoEntries(entries, file));
    if (stereo) {
      entries = std::move(*stereo);
      world = "a stereo calibration: the world is that of camera 1, lengths are the board's";
    }
  }
  CaptureDraft draft;
  draft.kind = "OpenCV";
  draft.pixelCentre = 0;
  if (world)
    draft.remarks.emplace_back(RemarkCode::kAssumed, world);
  for (const std::string& why : unread)
    draft.remarks.emplace_back(RemarkCode::kLeftOut,
                               "a file of its folder cannot be read and is left out: " + why);
  if (const OpenCvMatrix* fisheye = entries.find("fisheye_model");
      fisheye && fisheye->values != std::vector<double>{0}) {
    return fail(ErrorCode::kUnsupported,
                "{}: fisheye_model: fisheye lenses are not read; expected k1, k2, p1, p2, k3: "
                "undistort the pictures (cv::fisheye::undistortImage)",
                file.string());
  }
  VOLUTE_TRY(checkPoses(entries, file.string()));
  const CameraFinder finder(entries, file.string());
  for (const auto& [key, entry] : entries) {
    for (const std::string_view prefix : {"K_", "M_", "camera_matrix_"}) {
      if (!key.starts_with(prefix) || key.size() == prefix.size())
        continue;
      VOLUTE_ASSIGN(auto camera, finder.read(key.substr(prefix.size())));
      draft.cameras.push_back(std::move(camera));
    }
  }
  if (draft.cameras.empty()) {
    return fail(ErrorCode::kInvalidData,
                "{}: no cameras; expected matrices K_NAME, D_NAME, R_NAME and T_NAME for each",
                file.string());
  }
  if (const auto names = unused(entries, draft.cameras); !names.empty())
    draft.remarks.emplace_back(RemarkCode::kLeftOut,
                               fmt::format("no camera uses {}", fmt::join(names, ", ")));
  return draft;
}

}  // namespace volute
