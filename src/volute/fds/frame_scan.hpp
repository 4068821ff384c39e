// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>

#include "volute/fds/fortran_file.hpp"
#include "volute/fds/frame_times.hpp"

// What the files of frames share, inside of fds.

namespace volute {

constexpr std::size_t kFdsLabel = 30;  // bytes of a quantity's name or unit

inline std::string frameName(std::string_view what, std::size_t frame) {
  return fmt::format("the {} of frame {}", what, frame);
}

/// Of a frame, checked; kInvalidData names the byte, which is in the record at `offset`.
inline Result<double> checkedTime(const FortranFile& file, std::uint64_t offset, std::size_t frame,
                                  float time) {
  constexpr double kLatestTime = 1e9;  // [s]: later ones are damage
  if (std::abs(time) <= kLatestTime)
    return time;
  return fail(ErrorCode::kInvalidData,
              "{}: byte {}: the time of frame {} is {} s: the file is damaged",
              file.path().string(), offset + 4, frame, time);
}

/// Reads a frame's time; `offset` moves behind it.
inline Result<double> readTime(const FortranFile& file, std::uint64_t& offset, std::size_t frame) {
  float time = 0;
  const std::uint64_t begin = offset;
  VOLUTE_ASSIGN(offset, file.readInto(offset, std::span(&time, 1), frameName("time", frame)));
  return checkedTime(file, begin, frame, time);
}

/// True when the loop over frames is to end: the file ends within the frame, which gets a remark.
inline bool isCutOff(const Status& status, const FortranFile& file, std::uint64_t frameBegin,
                     FdsFrameIndex& frames) {
  if (status || status.error().code != ErrorCode::kTruncated)
    return false;
  frames.remarks.push_back(
      {RemarkCode::kDamaged,
       fmt::format("{}: ends at byte {}, within frame {} that begins at byte {}: {} whole frames "
                   "are used; the case may still be running",
                   file.path().string(), file.size(), frames.times.size(), frameBegin,
                   frames.times.size())});
  return true;
}

/// Calls one(offset, frame) until the file ends; it reads a frame, gives its time, and moves
/// offset behind it.
template <class One>
Status scanFrames(const FortranFile& file, std::uint64_t offset, FdsFrameIndex& frames,
                  const One& one) {
  std::size_t frame = 0;
  while (offset < file.size()) {
    const std::uint64_t begin = offset;
    const Result<double> time = one(offset, frame++);
    if (!time) {
      const Status status = tl::unexpected<Error>(time.error());
      return isCutOff(status, file, begin, frames) ? Status() : status;
    }
    frames.add(*time, begin, file.path().string());
  }
  return {};
}

/// Reads one number of a header, which must be `least` to `most`; `offset` moves behind it.
inline Result<int> readCount(const FortranFile& file, std::uint64_t& offset, std::string_view what,
                             std::int64_t least, std::int64_t most) {
  std::int32_t number = 0;
  const std::uint64_t begin = offset;
  VOLUTE_ASSIGN(offset, file.readInto(offset, std::span(&number, 1), what));
  if (number >= least && number <= most)
    return number;
  return fail(ErrorCode::kInvalidData, "{}: byte {}: {} is {}, expected {}{}: the file is damaged",
              file.path().string(), begin + 4, what, number, least,
              most > least ? fmt::format(" to {}", most) : "");
}

}  // namespace volute
