// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/image/colormap.hpp"
#include "volute/image/image.hpp"

namespace volute::cli {

/// How linear pictures become visible ones (.png, films); .exr files keep the linear values.
struct Development {
  double exposure = 1;               ///< a factor
  std::optional<ColorMap> colorMap;  ///< of the first channel, from 0 to 1 after the exposure
};

/// Where pictures go, in order; nothing appears before it is whole.
class PictureWriter {
 public:
  virtual ~PictureWriter() = default;
  [[nodiscard]] virtual Status write(const Image& image, int frameNumber) = 0;
  /// After the last picture.
  [[nodiscard]] virtual Status finish() = 0;
};

/// Files .png or .exr, one a picture: a pattern with the frame's number, or a plain name for a
/// single one.
[[nodiscard]] Result<std::unique_ptr<PictureWriter>> stillWriter(const std::string& target,
                                                                 const Development& development);

/// A film .mp4 or .webm.
[[nodiscard]] Result<std::unique_ptr<PictureWriter>> filmWriter(const std::string& target,
                                                                const Development& development,
                                                                int width, int height,
                                                                double framesPerSecond);

bool isFilmPath(const std::string& target);

}  // namespace volute::cli
