// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>

#include "volute/io/film.hpp"

namespace volute {

/// The frames of a film by their position. Going forward decodes each frame once; going back
/// decodes the film from its beginning again, for films can only be read in order.
class FilmFrames {
 public:
  [[nodiscard]] static Result<FilmFrames> open(const std::filesystem::path& path,
                                               std::uint64_t maxMemory = std::uint64_t{1} << 30);

  const FilmInfo& info() const { return reader_.info(); }

  /// Frame `index` (0 = the first) as linear RGB, decoded from sRGB; kNotFound when the film ends
  /// before it, with the number of frames that it has.
  [[nodiscard]] Result<Image> frame(int index);

 private:
  FilmFrames(FilmReader reader, std::filesystem::path path, std::uint64_t maxMemory)
      : reader_(std::move(reader)), path_(std::move(path)), maxMemory_(maxMemory) {}

  FilmReader reader_;
  std::filesystem::path path_;
  std::uint64_t maxMemory_;
  int next_ = 0;               // what reader_ gives next
  std::optional<Image> last_;  // frame next_ - 1
};

}  // namespace volute
