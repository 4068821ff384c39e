// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "bench/file_codec.hpp"
#include "volute/base/progress.hpp"

namespace volute::bench {

/// One codec's files of one sequence.
struct CodedFiles {
  std::filesystem::path folder;
  double setting = 0;          ///< what encode() was given
  double encodingSeconds = 0;  ///< of CPU time for one thread
  std::uint64_t bytes = 0;     ///< of all files
  double relativeRms = 0;      ///< of what was decoded from them
};

/// Files of `sequence` in `folder` (created; what was there is removed) whose decoded values are
/// within the relative RMS `target`, and close to it where the codec has a tolerance to search.
/// A codec without one gives what it gives. `threads` 0: all.
[[nodiscard]] Result<CodedFiles> encodeWithin(const FileCodec& codec, const Sequence& sequence,
                                              double target, const std::filesystem::path& folder,
                                              int threads, const Progress& progress);

/// Somebody who decodes against others.
struct Contestant {
  const FileCodec* codec = nullptr;
  std::filesystem::path folder;
  int threads = 1;     ///< 0: all
  double seconds = 0;  ///< filled in: the fastest of all rounds; of CPU time for one thread
};

/// Frames and voxels [begin, end) on the axes t, z, y, x.
struct Part {
  BlockGrid::Index4 begin{}, end{};
};

/// Contestants take turns, so that whatever else this machine does disturbs them alike.
/// @param part  what of the sequence is decoded; all without it
[[nodiscard]] Status raceDecoding(const VolumeInfo& info, std::span<Contestant> contestants,
                                  const Progress& progress,
                                  const std::optional<Part>& part = std::nullopt);

/// What encoding and decoding hold at most beside the values themselves [MiB]. Each in a process of
/// its own.
struct Memory {
  double encoding = 0, decoding = 0;
};

[[nodiscard]] Result<Memory> memoryOf(const FileCodec& codec, const Sequence& sequence,
                                      const CodedFiles& files,
                                      const std::filesystem::path& scratch);

}  // namespace volute::bench
