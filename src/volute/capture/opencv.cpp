// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <unordered_map>
#include <unordered_set>

#include "volute/base/file_name.hpp"
#include "volute/base/read_text.hpp"
#include "volute/capture/importers.hpp"
#include "volute/io/json_depth.hpp"

namespace volute {
namespace {

/// A matrix of the file, or a plain number as 1 x 1.
struct Entry {
  int rows = 0, columns = 0;
  std::vector<double> values;
};

/// In the order of the file.
class Entries {
 public:
  /// False: there is one of this name.
  bool add(const std::string& name, Entry entry) {
    if (!places_.emplace(name, list_.size()).second)
      return false;
    list_.emplace_back(name, std::move(entry));
    return true;
  }

  const Entry* find(const std::string& name) const {
    const auto found = places_.find(name);
    return found == places_.end() ? nullptr : &list_[found->second].second;
  }

  auto begin() const { return list_.begin(); }

  auto end() const { return list_.end(); }

 private:
  std::vector<std::pair<std::string, Entry>> list_;
  std::unordered_map<std::string, std::size_t> places_;
};

const Entry* findEntry(const Entries& entries, const std::string& name) {
  return entries.find(name);
}

std::optional<Entry> entryOf(const YAML::Node& node) {
  Entry entry;
  if (node.IsScalar()) {
    double value = 0;
    if (!YAML::convert<double>::decode(node, value))
      return std::nullopt;
    return Entry{1, 1, {value}};
  }
  if (!node.IsMap() || !node["rows"] || !node["cols"] || !node["data"])
    return std::nullopt;
  entry.rows = node["rows"].as<int>();
  entry.columns = node["cols"].as<int>();
  for (const auto& value : node["data"]) entry.values.push_back(value.as<double>());
  return entry;
}

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
Status checkPoses(const Entries& entries, const std::string& file) {
  const auto has = [&](std::initializer_list<const char*> prefixes, const std::string& name) {
    return std::ranges::any_of(
        prefixes, [&](const char* prefix) { return findEntry(entries, prefix + name) != nullptr; });
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
std::vector<std::string> unused(const Entries& entries, std::span<const CameraDraft> cameras) {
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
  return names;
}

/// JSON is YAML too, so one reader does for both. yaml-cpp throws.
Result<Entries> readEntries(const std::filesystem::path& file) {
  constexpr std::uint64_t kMaxBytes = 16 << 20;
  VOLUTE_ASSIGN(std::string text, readText(file, kMaxBytes));
  if (extensionOf(file) == ".json")
    VOLUTE_TRY(checkJsonDepth(text, file.string()));
  // OpenCV's first line is no YAML directive as the standard has it, and old versions put no "---"
  // after it.
  if (text.starts_with("%YAML"))
    text.replace(0, text.find('\n'), "# ");
  try {
    const YAML::Node root = YAML::Load(text);
    if (!root.IsMap())
      return fail(ErrorCode::kInvalidData,
                  "{}: holds no named matrices; expected OpenCV's FileStorage", file.string());
    Entries entries;
    std::size_t values = 0;
    for (const auto& item : root) {
      const auto name = item.first.as<std::string>();
      if (auto entry = entryOf(item.second)) {
        values += entry->values.size();
        if (values > text.size()) {
          return fail(ErrorCode::kTooLarge,
                      "{}: line {}: its matrices repeat others (as aliases, *name) more often than "
                      "the file has characters; expected each matrix written out",
                      file.string(), item.first.Mark().line + 1);
        }
        if (!entries.add(name, std::move(*entry))) {
          return fail(ErrorCode::kInvalidData, "{}: line {}: {} is there twice; expected it once",
                      file.string(), item.first.Mark().line + 1, name);
        }
      } else if (item.second.Tag().ends_with("opencv-matrix") || isOurs(name)) {
        return fail(ErrorCode::kInvalidData,
                    "{}: line {}: {} is no whole matrix; expected rows, cols and data: the file is "
                    "cut off or damaged",
                    file.string(), item.first.Mark().line + 1, name);
      }
    }
    return entries;
  } catch (const YAML::Exception& error) {
    return fail(ErrorCode::kInvalidData, "{}: line {}: no valid YAML or JSON: {}", file.string(),
                error.mark.line + 1, error.msg);
  }
}

class CameraFinder {
 public:
  CameraFinder(const Entries& entries, std::string file)
      : entries_(entries), file_(std::move(file)) {}

  Result<CameraDraft> read(const std::string& name) const {
    CameraDraft camera;
    camera.name = name;
    camera.where = fmt::format("{}: camera {}", file_, name);
    Calibration& calibration = camera.calibration;
    calibration.pixelCentre = 0;
    VOLUTE_ASSIGN(const Entry K, matrix({"K_", "M_", "camera_matrix_"}, name, 3, 3));
    calibration.K = toMatrix(K);
    VOLUTE_ASSIGN(calibration.distortion, distortion(name));
    VOLUTE_ASSIGN(calibration.R, rotation(name));
    VOLUTE_ASSIGN(const Entry t, matrix({"T_", "t_", "tvec_"}, name, 3, 1));
    calibration.t = Vec3(t.values[0], t.values[1], t.values[2]);
    readSize(name, calibration);
    return camera;
  }

 private:
  const Entry* find(std::initializer_list<const char*> prefixes, const std::string& name) const {
    for (const char* prefix : prefixes) {
      if (const Entry* entry = findEntry(entries_, prefix + name))
        return entry;
    }
    return nullptr;
  }

  Result<Entry> matrix(std::initializer_list<const char*> prefixes, const std::string& name,
                       int rows, int columns) const {
    const Entry* entry = find(prefixes, name);
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

  static Mat3 toMatrix(const Entry& entry) {
    Mat3 matrix;
    for (int i = 0; i < 9; ++i) matrix(i / 3, i % 3) = entry.values[static_cast<std::size_t>(i)];
    return matrix;
  }

  Result<Distortion> distortion(const std::string& name) const {
    const Entry* entry = find({"D_", "distortion_coefficients_", "dist_coeffs_"}, name);
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
    const Entry* entry = find({"R_", "rvec_"}, name);
    if (entry && entry->values.size() == 3) {
      const Vec3 axis(entry->values[0], entry->values[1], entry->values[2]);
      if (axis.norm() == 0)
        return Mat3(Mat3::Identity());
      return Mat3(Eigen::AngleAxisd(axis.norm(), axis.normalized()).toRotationMatrix());
    }
    VOLUTE_ASSIGN(const Entry R, matrix({"R_", "rvec_"}, name, 3, 3));
    return toMatrix(R);
  }

  void readSize(const std::string& name, Calibration& calibration) const {
    const Entry* width = find({"image_width_", "width_"}, name);
    const Entry* height = find({"image_height_", "height_"}, name);
    width = width ? width : findEntry(entries_, "image_width");
    height = height ? height : findEntry(entries_, "image_height");
    constexpr double kMax = 1 << 20;
    for (const auto& [entry, side] :
         {std::pair(width, &calibration.width), std::pair(height, &calibration.height)}) {
      if (entry && entry->values.size() == 1 && entry->values[0] >= 1 && entry->values[0] <= kMax)
        *side = static_cast<int>(entry->values[0]);
    }
  }

  const Entries& entries_;
  std::string file_;
};

}  // namespace

Result<CaptureDraft> readOpenCv(const std::filesystem::path& file) {
  VOLUTE_ASSIGN(const auto entries, readEntries(file));
  CaptureDraft draft;
  draft.kind = "OpenCV";
  draft.pixelCentre = 0;
  if (const Entry* fisheye = findEntry(entries, "fisheye_model");
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
    draft.remarks.push_back(fmt::format("no camera uses {}", fmt::join(names, ", ")));
  return draft;
}

}  // namespace volute
