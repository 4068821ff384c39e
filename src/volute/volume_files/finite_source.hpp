// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "volute/grid/frame_source.hpp"

namespace volute {

/// What becomes of values that are no finite numbers.
enum class NotFinite {
  kKeep,
  kRefuse,      ///< an error with file, grid, frame, the voxel as the file counts it, and its place
  kBackground,  ///< the background instead; they stay active where they were
  kInactive,    ///< they are not there, as withoutHoles() has it
};

/// How many values were replaced as they were no finite numbers. Layers may be read several times.
class ReplacedValues {
 public:
  void set(int frame, int layer, std::uint64_t count);

  std::uint64_t count() const;

 private:
  std::map<std::pair<int, int>, std::uint64_t> counts_;  // of a layer of a frame
};

/// @param source  as it was opened: a PlacedFrames names its files and indices
/// @param path  of the input
/// @param counts  of what is replaced; null: nobody asks
std::unique_ptr<FrameSource> asFinite(std::unique_ptr<FrameSource> source, NotFinite what,
                                      const std::string& path,
                                      std::shared_ptr<ReplacedValues> counts = {});

}  // namespace volute
