// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/io/frame_pattern.hpp"

namespace volute {

/// The names of all pictures of a capture: {camera} stands for the camera's name (in the file's or
/// its folder's name), %04d, %d or #### for the frame's number in the file's name. Either may be
/// missing: then there is one camera, or one frame.
class ImageName {
 public:
  /// kInvalidArgument for a text without {camera} twice, or with more than one frame number.
  [[nodiscard]] static Result<ImageName> parse(const std::string& text);

  bool hasCamera() const { return hasCamera_; }

  bool hasFrame() const;

  /// The files of one camera, with the frame number still open.
  std::string ofCamera(std::string_view camera) const;

  std::string file(std::string_view camera, int frame) const;

  /// The camera's name in the name of one of its pictures, whatever the frame and the extension;
  /// folders count as far as the name has them. Nothing when the name is of another form.
  std::optional<std::string> cameraIn(const std::string& pictureName) const;

  const std::string& text() const { return text_; }

 private:
  std::string text_;
  bool hasCamera_ = false;
};

/// The file of frame `number`; names without a frame number stay as they are.
std::string frameFile(const std::string& pattern, int number);

/// The frames that are there of such a name; a name without a number is frame 0.
std::vector<int> framesThere(const std::string& pattern, FolderFiles& folders);

}  // namespace volute
