// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <string>

#include "volute/grid/frame_source.hpp"

namespace volute {

/// What becomes of values that are no finite numbers.
enum class NotFinite {
  kKeep,
  kRefuse,      ///< an error with file, grid, frame, the voxel as the file counts it, and its place
  kBackground,  ///< the background instead; they stay active where they were
  kInactive,    ///< they are not there, as withoutHoles() has it
};

/// @param source  as it was opened: a PlacedFrames names its files and indices
/// @param path  of the input
std::unique_ptr<FrameSource> asFinite(std::unique_ptr<FrameSource> source, NotFinite what,
                                      const std::string& path);

}  // namespace volute
