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

/// What stands between <name ...> and </name>, from `at` on, which goes behind it; nothing at the
/// end of the text.
struct XmlElement {
  std::string_view name, content;
};

Result<std::optional<XmlElement>> nextElement(std::string_view text, std::size_t& at,
                                              const std::string& file) {
  while ((at = text.find('<', at)) != std::string_view::npos) {
    const bool comment = text.substr(at).starts_with("<!--");
    const std::size_t end = text.find(comment ? "-->" : ">", at);
    if (end == std::string_view::npos)
      return fail(ErrorCode::kInvalidData, "{}: a tag is cut off at its end", file);
    const std::string_view tag = text.substr(at + 1, end - at - 1);
    at = end + (comment ? 3 : 1);
    if (comment || tag.starts_with('?') || tag.starts_with('!') || tag.ends_with('/'))
      continue;
    const std::string_view name = tag.substr(0, tag.find_first_of(" \t\r\n"));
    const std::string close = fmt::format("</{}>", name);
    const std::size_t last = text.find(close, at);
    if (name.empty() || name.starts_with('/') || last == std::string_view::npos)
      return fail(ErrorCode::kInvalidData, "{}: <{}> has no end: the file is cut off or damaged",
                  file, name);
    const XmlElement element{name, text.substr(at, last - at)};
    at = last + close.size();
    return element;
  }
  return std::nullopt;
}

/// All numbers of a text; nothing where there is something else.
std::optional<std::vector<double>> numbersOf(std::string_view text) {
  std::vector<double> numbers;
  const std::string copy(text);
  const char* at = copy.c_str();
  for (char* after = nullptr;; at = after) {
    const double number = std::strtod(at, &after);
    if (after == at)
      break;
    numbers.push_back(number);
  }
  if (std::string_view(at).find_first_not_of(" \t\r\n") != std::string_view::npos)
    return std::nullopt;
  return numbers;
}

/// OpenCV's XML: <opencv_storage> of matrices with <rows>, <cols> and <data>, and of numbers.
Result<Entries> xmlEntries(std::string_view text, const std::string& file) {
  constexpr double kMaxCount = 1e6;  // rows, or columns
  std::size_t at = 0;
  VOLUTE_ASSIGN(const auto root, nextElement(text, at, file));
  if (!root || root->name != "opencv_storage")
    return fail(ErrorCode::kInvalidData, "{}: expected OpenCV's <opencv_storage>", file);
  Entries entries;
  at = 0;
  while (true) {
    VOLUTE_ASSIGN(const auto element, nextElement(root->content, at, file));
    if (!element)
      return entries;
    const std::string name(element->name);
    Entry entry;
    if (auto number = numbersOf(element->content)) {
      if (number->size() != 1)
        continue;  // lists, or nothing
      entry = {1, 1, std::move(*number)};
    } else {
      std::optional<std::vector<double>> rows, columns, data;
      std::size_t inside = 0;
      while (element->content.find('<', inside) != std::string_view::npos) {
        VOLUTE_ASSIGN(const auto part, nextElement(element->content, inside, file));
        if (!part)
          break;
        auto& to = part->name == "rows" ? rows : part->name == "cols" ? columns : data;
        if (part->name == "rows" || part->name == "cols" || part->name == "data")
          to = numbersOf(part->content);
      }
      const auto count = [](const std::optional<std::vector<double>>& of) {
        return of && of->size() == 1 && of->front() >= 1 && of->front() <= kMaxCount
                   ? static_cast<std::size_t>(of->front())
                   : 0;
      };
      const bool whole = data && !data->empty() && data->size() == count(rows) * count(columns);
      if (!whole && !isOurs(name))
        continue;  // words, or other structures
      if (!whole)
        return fail(ErrorCode::kInvalidData,
                    "{}: {} is no whole matrix; expected rows, cols and data: the file is cut off "
                    "or damaged",
                    file, name);
      entry = {static_cast<int>(count(rows)), static_cast<int>(count(columns)), std::move(*data)};
    }
    if (!entries.add(name, std::move(entry)))
      return fail(ErrorCode::kInvalidData, "{}: {} is there twice; expected it once", file, name);
  }
}

/// JSON is YAML too, so one reader does for both. yaml-cpp throws.
Result<Entries> readEntries(const std::filesystem::path& file) {
  constexpr std::uint64_t kMaxBytes = 16 << 20;
  VOLUTE_ASSIGN(std::string text, readText(file, kMaxBytes));
  if (extensionOf(file) == ".xml")
    return xmlEntries(text, file.string());
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

Entry identity() {
  return {3, 3, {1, 0, 0, 0, 1, 0, 0, 0, 1}};
}

/// Of several names the one that is there.
const Entry* anyOf(const Entries& entries, std::initializer_list<const char*> names) {
  for (const char* name : names) {
    if (const Entry* entry = entries.find(name))
      return entry;
  }
  return nullptr;
}

/// A file of the same folder and ending, e.g. "extrinsics" beside intrinsics.yml.
Result<std::optional<Entries>> sibling(const std::filesystem::path& file, const char* name) {
  auto other = file;
  other.replace_filename(name + file.extension().string());
  std::error_code error;
  if (other == file || !std::filesystem::exists(other, error))
    return std::nullopt;
  VOLUTE_ASSIGN(auto entries, readEntries(other));
  return entries;
}

/// What OpenCV's stereo sample writes: M1, D1, M2, D2 in intrinsics.yml, and R and T from the first
/// camera to the second in extrinsics.yml, or all in one file; as cameras 1 and 2, the world that
/// of the first. Nothing for other files.
Result<std::optional<Entries>> stereoEntries(const Entries& entries,
                                             const std::filesystem::path& file) {
  const auto matrix = [](const Entries& of, int camera) {
    return camera == 1 ? anyOf(of, {"M1", "cameraMatrix1", "K1"})
                       : anyOf(of, {"M2", "cameraMatrix2", "K2"});
  };
  const bool pose = entries.find("R") && entries.find("T");
  const bool lenses = matrix(entries, 1) && matrix(entries, 2);
  if (!pose && !lenses)
    return std::nullopt;
  std::optional<Entries> other;
  if (!pose || !lenses) {
    VOLUTE_ASSIGN(other, sibling(file, pose ? "intrinsics" : "extrinsics"));
  }
  const Entries& poses = pose || !other ? entries : *other;
  const Entries& cameras = lenses || !other ? entries : *other;
  if (!poses.find("R") || !poses.find("T") || !matrix(cameras, 1) || !matrix(cameras, 2))
    return fail(ErrorCode::kInvalidData,
                "{}: a stereo calibration without {}; expected {}{} beside it, or all in one file",
                file.string(), pose ? "M1 and M2" : "R and T", pose ? "intrinsics" : "extrinsics",
                file.extension().string());
  Entries named;
  for (const int camera : {1, 2}) {
    const std::string name = std::to_string(camera);
    named.add("K_" + name, *matrix(cameras, camera));
    const Entry* lens =
        camera == 1 ? anyOf(cameras, {"D1", "distCoeffs1"}) : anyOf(cameras, {"D2", "distCoeffs2"});
    if (lens)
      named.add("D_" + name, *lens);
    named.add("R_" + name, camera == 1 ? identity() : *poses.find("R"));
    named.add("T_" + name, camera == 1 ? Entry{3, 1, {0, 0, 0}} : *poses.find("T"));
  }
  for (const char* size : {"image_width", "image_height"}) {
    if (const Entry* entry = entries.find(size))
      named.add(size, *entry);
  }
  return named;
}

/// What OpenCV's calibration sample writes of one camera: camera_matrix, distortion_coefficients
/// and a row of extrinsic_parameters for each view of the board.
bool isSample(const Entries& entries) {
  return entries.find("camera_matrix") && entries.find("extrinsic_parameters");
}

/// Such files of one folder and ending are cameras by the files' names, in the world of the board
/// in their first view.
Result<Entries> sampleEntries(const std::filesystem::path& file) {
  std::vector<std::filesystem::path> files;
  std::error_code error;
  const auto folder = file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
  for (const auto& other : std::filesystem::directory_iterator(folder, error)) {
    if (other.path().extension() == file.extension())
      files.push_back(other.path());
  }
  std::ranges::sort(files);
  Entries named;
  for (const auto& other : files) {
    const auto entries = readEntries(other);
    if (!entries && other.filename() == file.filename())
      return entries;
    if (!entries || !isSample(*entries))
      continue;
    const std::string name = other.stem().string();
    const Entry& poses = *entries->find("extrinsic_parameters");
    if (poses.columns != 6 || poses.rows < 1 || poses.values.size() < 6)
      return fail(ErrorCode::kInvalidData,
                  "{}: extrinsic_parameters is {} x {}; expected rows of six numbers: a rotation "
                  "vector and a translation",
                  other.string(), poses.rows, poses.columns);
    named.add("K_" + name, *entries->find("camera_matrix"));
    if (const Entry* lens = entries->find("distortion_coefficients"))
      named.add("D_" + name, *lens);
    const auto& v = poses.values;
    named.add("rvec_" + name, {3, 1, {v[0], v[1], v[2]}});
    named.add("T_" + name, {3, 1, {v[3], v[4], v[5]}});
    for (const char* size : {"image_width", "image_height"}) {
      if (const Entry* entry = entries->find(size))
        named.add(size + ("_" + name), *entry);
    }
    const Entry* fisheye = entries->find("fisheye_model");
    if (fisheye && fisheye->values != std::vector<double>{0})
      named.add("fisheye_model", *fisheye);
  }
  return named;
}

}  // namespace

Result<CaptureDraft> readOpenCv(const std::filesystem::path& file) {
  VOLUTE_ASSIGN(auto entries, readEntries(file));
  const char* world = nullptr;
  if (isSample(entries)) {
    VOLUTE_ASSIGN(entries, sampleEntries(file));
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
    draft.remarks.emplace_back(world);
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
