// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/capture/colmap_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <optional>
#include <sstream>

#include "volute/base/file_name.hpp"
#include "volute/base/number_word.hpp"
#include "volute/base/read_text.hpp"

namespace volute {
namespace {

constexpr std::uint64_t kMaxBytes = std::uint64_t{1} << 30;

// In the order of COLMAP's numbers, with how many parameters each has.
struct Model {
  std::string_view name;
  int parameters;
};

constexpr std::array<Model, 12> kModels{{{"SIMPLE_PINHOLE", 3},
                                         {"PINHOLE", 4},
                                         {"SIMPLE_RADIAL", 4},
                                         {"RADIAL", 5},
                                         {"OPENCV", 8},
                                         {"OPENCV_FISHEYE", 8},
                                         {"FULL_OPENCV", 12},
                                         {"FOV", 5},
                                         {"SIMPLE_RADIAL_FISHEYE", 4},
                                         {"RADIAL_FISHEYE", 5},
                                         {"THIN_PRISM_FISHEYE", 12},
                                         {"RAD_TAN_THIN_PRISM_FISHEYE", 16}}};

/// What an image takes until it is a camera of a capture, all copies of its names included.
constexpr std::uint64_t kBytesOfAnImage = 2048;

Status checkMemory(const std::filesystem::path& path, std::uint64_t images, std::uint64_t most) {
  if (images <= most / kBytesOfAnImage)
    return {};
  return fail(ErrorCode::kTooLarge, Hint::raise("max_memory"),
              "{}: has more than {} images, which need more than the {} MiB allowed", path.string(),
              most / kBytesOfAnImage, most >> 20);
}

std::vector<std::string> wordsOf(const std::string& line) {
  std::istringstream stream(line);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

/// Lines with their numbers; comments left out, empty lines kept.
struct Line {
  int number = 0;
  std::vector<std::string> words;
};

template <class Take>
Status forEachLine(const std::string& text, Take&& take) {
  int number = 0;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    ++number;
    if (text[at] != '#')
      VOLUTE_TRY(take(Line{number, wordsOf(text.substr(at, end - at))}));
    at = end + 1;
  }
  return {};
}

/// What COLMAP itself writes above: "# Number of images: 8, mean observations per image: 312.5".
std::optional<std::size_t> statedCount(const std::string& text, std::string_view noun) {
  const std::string key = fmt::format("Number of {}:", noun);
  for (std::size_t at = 0; at < text.size() && text[at] == '#';) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string line = text.substr(at, end - at);
    if (const auto found = line.find(key); found != std::string::npos) {
      const auto words = wordsOf(line.substr(found + key.size()));
      std::size_t count = 0;
      const std::string number = words.empty() ? "" : words[0].substr(0, words[0].find(','));
      if (readNumber(number, count))
        return count;
    }
    at = end + 1;
  }
  return std::nullopt;
}

/// A text that was cut off between lines says less than it states; one cut within a line has no
/// end of line.
Status checkWhole(const std::filesystem::path& path, const std::string& text, std::string_view noun,
                  std::size_t found, ColmapModel& model) {
  const auto stated = statedCount(text, noun);
  if (stated && *stated != found) {
    return fail(ErrorCode::kTruncated,
                "{}: has {} {}, and says at its begin that there are {}: lines are missing or too "
                "many; copy the file again, or mend the line '# Number of {}'",
                path.string(), found, noun, *stated, noun);
  }
  if (text.ends_with('\n'))
    return {};
  if (stated) {
    return fail(ErrorCode::kTruncated,
                "{}: does not end in an end of line: its last line is cut off; copy the file again",
                path.string());
  }
  model.remarks.push_back(fmt::format(
      "{}: does not end in an end of line: its last line may be cut off", path.string()));
  return {};
}

Status readCamerasText(const std::filesystem::path& path, std::uint64_t maxMemory,
                       ColmapModel& model) {
  VOLUTE_ASSIGN(const std::string text, readText(path, std::min(kMaxBytes, maxMemory)));
  VOLUTE_TRY(forEachLine(text, [&](const Line& line) -> Status {
    if (line.words.empty())
      return {};
    VOLUTE_TRY(checkMemory(path, model.cameras.size(), maxMemory));
    ColmapCamera camera;
    std::uint32_t id = 0;
    bool good = line.words.size() >= 5 && readNumber(line.words[0], id) &&
                readNumber(line.words[2], camera.width) && readNumber(line.words[3], camera.height);
    if (good)
      camera.model = line.words[1];
    for (std::size_t i = 4; good && i < line.words.size(); ++i)
      good = readNumber(line.words[i], camera.parameters.emplace_back());
    if (!good || camera.width < 1 || camera.height < 1) {
      return fail(ErrorCode::kInvalidData,
                  "{}: line {}: expected CAMERA_ID MODEL WIDTH HEIGHT PARAMS", path.string(),
                  line.number);
    }
    if (!model.cameras.emplace(id, std::move(camera)).second) {
      return fail(ErrorCode::kInvalidData, "{}: line {}: camera {} is there twice", path.string(),
                  line.number, id);
    }
    return {};
  }));
  return checkWhole(path, text, "cameras", model.cameras.size(), model);
}

bool parseImage(const Line& line, ColmapImage& image) {
  if (line.words.size() < 10)
    return false;
  std::array<double, 7> pose{};
  for (std::size_t i = 0; i < pose.size(); ++i) {
    if (!readNumber(line.words[i + 1], pose[i]))
      return false;
  }
  std::uint32_t id = 0;
  double number = 0;
  if (!readNumber(line.words[0], id) || !readNumber(line.words[8], image.camera) ||
      readNumber(line.words[9], number)) {
    return false;
  }
  image.name = line.words[9];
  for (std::size_t i = 10; i < line.words.size(); ++i) image.name += " " + line.words[i];
  image.rotation = {pose[0], pose[1], pose[2], pose[3]};
  image.translation = Vec3(pose[4], pose[5], pose[6]);
  return true;
}

/// Each image has a line of its own and one of points, which may be empty and which some tools
/// leave out.
Status readImagesText(const std::filesystem::path& path, std::uint64_t maxMemory,
                      ColmapModel& model) {
  VOLUTE_ASSIGN(const std::string text, readText(path, std::min(kMaxBytes, maxMemory)));
  bool pointsMayFollow = false;
  VOLUTE_TRY(forEachLine(text, [&](const Line& line) -> Status {
    ColmapImage image;
    if (parseImage(line, image)) {
      image.where = fmt::format("{}: line {}", path.string(), line.number);
      model.images.push_back(std::move(image));
      pointsMayFollow = true;
      return checkMemory(path, model.images.size(), maxMemory);
    }
    const bool points = line.words.empty() || (pointsMayFollow && line.words.size() % 3 == 0);
    if (!points) {
      return fail(ErrorCode::kInvalidData,
                  "{}: line {}: expected IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME",
                  path.string(), line.number);
    }
    pointsMayFollow = false;
    return {};
  }));
  return checkWhole(path, text, "images", model.images.size(), model);
}

/// Little-endian values one after another; after the end all are zero and ok() is false.
class Bytes {
 public:
  explicit Bytes(const std::string& bytes) : bytes_(bytes) {}

  template <class T>
  T take() {
    static_assert(std::endian::native == std::endian::little);
    T value{};
    if (bytes_.size() - at_ < sizeof(T)) {
      ok_ = false;
      return value;
    }
    std::memcpy(&value, bytes_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    return value;
  }

  std::string takeText() {
    const auto end = bytes_.find('\0', at_);
    if (end == std::string::npos) {
      ok_ = false;
      return "";
    }
    std::string text = bytes_.substr(at_, end - at_);
    at_ = end + 1;
    return text;
  }

  void skip(std::uint64_t count, std::uint64_t size) {
    if ((bytes_.size() - at_) / size < count) {
      ok_ = false;
    } else {
      at_ += count * size;
    }
  }

  bool ok() const { return ok_; }

  bool atEnd() const { return at_ == bytes_.size(); }

  std::size_t at() const { return at_; }

 private:
  const std::string& bytes_;
  std::size_t at_ = 0;
  bool ok_ = true;
};

tl::unexpected<Error> damaged(const std::filesystem::path& path, const Bytes& bytes) {
  return fail(ErrorCode::kTruncated, "{}: byte {}: no whole COLMAP model; the file is damaged",
              path.string(), bytes.at());
}

Status readCamerasBinary(const std::filesystem::path& path, std::uint64_t maxMemory,
                         ColmapModel& model) {
  VOLUTE_ASSIGN(const std::string text, readText(path, std::min(kMaxBytes, maxMemory)));
  Bytes bytes(text);
  const auto count = bytes.take<std::uint64_t>();
  for (std::uint64_t i = 0; i < count && bytes.ok(); ++i) {
    const auto id = bytes.take<std::uint32_t>();
    const auto number = bytes.take<std::int32_t>();
    if (!bytes.ok())
      return damaged(path, bytes);
    if (number < 0 || number >= static_cast<int>(kModels.size())) {
      return fail(ErrorCode::kUnsupported,
                  "{}: camera {}: its model has the number {}, which is not known (0 to {}); the "
                  "file is damaged, or newer: `colmap model_converter` writes it as text",
                  path.string(), id, number, kModels.size() - 1);
    }
    ColmapCamera camera;
    camera.model = kModels[static_cast<std::size_t>(number)].name;
    const auto width = bytes.take<std::uint64_t>(), height = bytes.take<std::uint64_t>();
    if (width > 1 << 20 || height > 1 << 20)
      return damaged(path, bytes);
    camera.width = static_cast<int>(width), camera.height = static_cast<int>(height);
    for (int k = 0; k < kModels[static_cast<std::size_t>(number)].parameters; ++k)
      camera.parameters.push_back(bytes.take<double>());
    model.cameras[id] = std::move(camera);
    VOLUTE_TRY(checkMemory(path, model.cameras.size(), maxMemory));
  }
  if (!bytes.ok() || !bytes.atEnd())
    return damaged(path, bytes);
  return {};
}

Status readImagesBinary(const std::filesystem::path& path, std::uint64_t maxMemory,
                        ColmapModel& model) {
  VOLUTE_ASSIGN(const std::string text, readText(path, std::min(kMaxBytes, maxMemory)));
  Bytes bytes(text);
  const auto count = bytes.take<std::uint64_t>();
  for (std::uint64_t i = 0; i < count && bytes.ok(); ++i) {
    ColmapImage image;
    image.where = fmt::format("{}: image {}", path.string(), bytes.take<std::uint32_t>());
    for (double& value : image.rotation) value = bytes.take<double>();
    for (int axis = 0; axis < 3; ++axis) image.translation[axis] = bytes.take<double>();
    image.camera = bytes.take<std::uint32_t>();
    image.name = bytes.takeText();
    bytes.skip(bytes.take<std::uint64_t>(), 24);  // x, y and the point's number
    if (bytes.ok())
      model.images.push_back(std::move(image));
    VOLUTE_TRY(checkMemory(path, model.images.size(), maxMemory));
  }
  if (!bytes.ok() || !bytes.atEnd())
    return damaged(path, bytes);
  return {};
}

}  // namespace

Result<ColmapModel> readColmapFiles(const std::filesystem::path& path, std::uint64_t maxMemory) {
  std::error_code ignored;
  const bool whole = std::filesystem::is_directory(path, ignored);
  const auto folder = whole ? path : path.parent_path();
  const std::string ending = whole ? "" : extensionOf(path);
  const auto has = [&](const std::string& name) {
    std::error_code error;
    return name.ends_with(ending) && std::filesystem::exists(folder / name, error);
  };
  ColmapModel model;
  if (has("cameras.txt") && has("images.txt")) {
    if (has("cameras.bin") && has("images.bin"))
      model.remarks.emplace_back(
          "the folder has cameras and images as .txt and as .bin, and the .txt were read; name a "
          "file of those that count");
    VOLUTE_TRY(readCamerasText(folder / "cameras.txt", maxMemory, model));
    VOLUTE_TRY(readImagesText(folder / "images.txt", maxMemory, model));
    return model;
  }
  if (has("cameras.bin") && has("images.bin")) {
    VOLUTE_TRY(readCamerasBinary(folder / "cameras.bin", maxMemory, model));
    VOLUTE_TRY(readImagesBinary(folder / "images.bin", maxMemory, model));
    return model;
  }
  std::vector<std::string> there;
  for (const char* name : {"cameras.txt", "images.txt", "cameras.bin", "images.bin"}) {
    if (has(name))
      there.emplace_back(name);
  }
  if (there.empty()) {
    return fail(ErrorCode::kNotFound,
                "{}: no COLMAP model in this folder; expected cameras.txt and images.txt, or .bin",
                folder.string());
  }
  return fail(ErrorCode::kNotFound,
              "{}: half a COLMAP model: only {} {} there; expected cameras (the lenses) and images "
              "(the poses), both as .txt or both as .bin",
              folder.string(), fmt::join(there, " and "), there.size() > 1 ? "are" : "is");
}

}  // namespace volute
