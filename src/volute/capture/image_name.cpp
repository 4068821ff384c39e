// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/capture/image_name.hpp"

#include <filesystem>
#include <numeric>
#include <regex>

#include "volute/capture/capture.hpp"

namespace volute {
namespace {

constexpr std::string_view kCamera = "{camera}";

std::string escaped(char c) {
  constexpr std::string_view kSpecial = R"(.^$|()[]{}*+?\)";
  return kSpecial.find(c) == std::string_view::npos ? std::string(1, c) : std::string{'\\', c};
}

/// A component of a pattern as a regular expression: {camera} is a group, the frame number of the
/// last component is digits or stands open.
std::string expressionOf(const std::string& component, bool last) {
  const auto found = last ? findFrameField(component) : std::optional<FrameField>();
  const bool has = found && *found;
  // NOLINTNEXTLINE(bugprone-unchecked-optional-access): 'has' asks for it
  const FrameField field = has ? **found : FrameField{};
  std::string expression;
  for (std::size_t at = 0; at < component.size();) {
    if (component.compare(at, kCamera.size(), kCamera) == 0) {
      expression += "(.+)";
      at += kCamera.size();
    } else if (has && at == field.begin) {
      expression += "(?:-?[0-9]+|#+|%0?[0-9]*d)";
      at = field.end;
    } else {
      at += has && component.compare(at, 2, "%%") == 0 ? 1 : 0;
      expression += escaped(component[at++]);
    }
  }
  return expression;
}

std::vector<std::string> componentsOf(const std::filesystem::path& path) {
  std::vector<std::string> components;
  for (const auto& part : path.parent_path()) components.push_back(part.string());
  components.push_back(path.stem().string());
  return components;
}

}  // namespace

Result<ImageName> ImageName::parse(const std::string& text) {
  ImageName name;
  name.text_ = text;
  const auto first = text.find(kCamera);
  name.hasCamera_ = first != std::string::npos;
  if (text.empty())
    return fail(ErrorCode::kInvalidArgument, "the pattern of the images is empty");
  if (name.hasCamera_ && text.find(kCamera, first + 1) != std::string::npos) {
    return fail(ErrorCode::kInvalidArgument, "{}: {{camera}} stands in it twice; expected once",
                text);
  }
  if (name.hasFrame())
    VOLUTE_TRY(FramePattern::parse(name.ofCamera("c")));
  return name;
}

bool ImageName::hasFrame() const {
  return namesSeries(text_);
}

std::string ImageName::ofCamera(std::string_view camera) const {
  std::string text = text_;
  if (hasCamera_)
    text.replace(text.find(kCamera), kCamera.size(), camera);
  return text;
}

std::string ImageName::file(std::string_view camera, int frame) const {
  return frameFile(ofCamera(camera), frame);
}

std::optional<std::string> ImageName::cameraIn(const std::string& pictureName) const {
  if (!hasCamera_)
    return std::nullopt;
  const auto pattern = componentsOf(text_), given = componentsOf(pictureName);
  std::string camera;
  bool found = false;
  for (std::size_t i = 0; i < std::min(pattern.size(), given.size()); ++i) {
    const std::string& wanted = pattern[pattern.size() - 1 - i];
    const bool folderOfFiles = i > 0 && found;  // a calibration need not lie in the same folders
    if (folderOfFiles)
      break;
    std::smatch match;
    const std::string& part = given[given.size() - 1 - i];
    if (!std::regex_match(part, match, std::regex(expressionOf(wanted, i == 0))))
      return std::nullopt;
    if (match.size() > 1) {
      camera = match[1];
      found = true;
    }
  }
  return found ? std::optional(camera) : std::nullopt;
}

std::string frameFile(const std::string& pattern, int number) {
  if (!namesSeries(pattern))
    return pattern;
  const auto parsed = FramePattern::parse(pattern);
  return parsed ? parsed->format(number).string() : pattern;
}

std::vector<int> framesThere(const std::string& pattern, FolderFiles& folders) {
  std::vector<int> frames;
  if (!namesSeries(pattern)) {
    std::error_code error;
    if (std::filesystem::exists(pattern, error))
      frames.push_back(0);
    return frames;
  }
  const auto parsed = FramePattern::parse(pattern);
  if (!parsed)
    return frames;
  const auto files = parsed->list(folders);
  for (std::size_t i = 0; files && i < files->size(); ++i) frames.push_back((*files)[i].number);
  return frames;
}

std::filesystem::path PictureSource::fileOf(int number) const {
  return frameFile(image, number);
}

bool PictureSource::isThere(int number) const {
  std::error_code error;
  return std::filesystem::exists(fileOf(number), error) &&
         (pages == 1 || (number >= 0 && number < pages));
}

std::vector<int> PictureSource::numbersThere(FolderFiles& folders) const {
  if (pages == 1)
    return framesThere(image, folders);
  std::vector<int> numbers(static_cast<std::size_t>(pages));
  std::iota(numbers.begin(), numbers.end(), 0);
  return numbers;
}

}  // namespace volute
