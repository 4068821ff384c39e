// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "volute/grid/frame_source.hpp"
#include "volute/grid/grid_description.hpp"

namespace volute {

/// `source` with its background where values are no finite numbers; they stay active where they
/// were.
std::unique_ptr<FrameSource> asFinite(std::unique_ptr<FrameSource> source);

/// The first value of a source that is no finite number: its frame, its voxel as the file counts
/// it, and where that is in the world. Nothing where there is none, or a frame cannot be read.
/// @param description  of the grid; null: voxels count from the first one
std::optional<std::string> firstNotFinite(FrameSource& source, const GridDescription* description);

}  // namespace volute
