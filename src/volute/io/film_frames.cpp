// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/film_frames.hpp"

#include "volute/base/assert.hpp"

namespace volute {

Result<FilmFrames> FilmFrames::open(const std::filesystem::path& path, std::uint64_t maxMemory) {
  VOLUTE_ASSIGN(auto reader, FilmReader::open(path, maxMemory));
  return FilmFrames(std::move(reader), path, maxMemory);
}

Result<Image> FilmFrames::frame(int index) {
  VOLUTE_ASSERT(index >= 0);
  if (last_ && index == next_ - 1)
    return *last_;
  if (index < next_) {
    VOLUTE_ASSIGN(auto reader, FilmReader::open(path_, maxMemory_));
    reader_ = std::move(reader);
    next_ = 0;
  }
  while (next_ <= index) {
    VOLUTE_ASSIGN(last_, reader_.next());
    if (!last_) {
      const int frames = next_;
      VOLUTE_ASSIGN(auto reader, FilmReader::open(path_, maxMemory_));
      reader_ = std::move(reader);
      next_ = 0;
      return fail(ErrorCode::kNotFound, "{}: the film has {} frames; frame {} was asked for",
                  path_.string(), frames, index);
    }
    ++next_;
  }
  // NOLINTNEXTLINE(bugprone-unchecked-optional-access): the loop ends with one
  return *last_;
}

}  // namespace volute
