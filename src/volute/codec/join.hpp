// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "volute/base/progress.hpp"
#include "volute/base/result.hpp"
#include "volute/codec/compress.hpp"

namespace volute {

struct JoinOptions {
  /// Relative RMS to the parts when they must be encoded again; none: what the parts have
  /// themselves.
  std::optional<double> rms;
  std::uint64_t maxMemory = std::uint64_t{4} << 30;  ///< [bytes]
  std::optional<double> framesPerSecond{};           ///< sets the times of frames, by their numbers
};

struct JoinReport {
  /// The faint frames of a grid that was encoded again: their errors are to the parts.
  struct Faint {
    std::string grid;
    std::vector<FaintFrame> frames;
  };

  VolumeInfo info;  ///< frames and times of the whole
  /// True when blocks were copied as they are: every value of the joined file is exactly that of
  /// its part.
  bool copied = false;
  double partsRms = 0;     ///< relative RMS that was added to the parts; 0 when copied
  double relativeRms = 0;  ///< to the originals, at most; relative to the range of all parts
  double maxError = 0;     ///< to the originals, at most; absolute
  std::uint64_t fileBytes = 0;
  std::vector<Faint> faint{};
};

/// Puts .volute files together in the order of their frame numbers, which must not
/// overlap. Times that begin anew in each part go on in the steps of the first, which is remarked.
///
/// Blocks are copied byte for byte, and no value changes, when those of all parts have as many
/// frames, all parts but the last have a multiple of that, and all the same volume; the file lists
/// what its parts do not have in common. Otherwise the parts are decoded and encoded again. That
/// adds an error to theirs; the file states their sum, which the error to the originals does not
/// exceed.
///
/// Of files with several grids, or with what a cache says of its one, each grid is joined by
/// itself. Its volume becomes the least around those of all files, with the cache's background
/// where a file has none; errors are those of the worst grid.
///
/// kInvalidData, with the names of both files, when grids, bounds, channels, basis, units, up axes
/// or frames do not fit together. Where a part states no up axis, that of the others is taken,
/// which is remarked.
[[nodiscard]] Result<JoinReport> join(const std::vector<std::filesystem::path>& parts,
                                      const std::filesystem::path& target,
                                      const JoinOptions& options, Progress& progress);

}  // namespace volute
