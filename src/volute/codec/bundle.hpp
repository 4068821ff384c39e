// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "volute/base/progress.hpp"
#include "volute/base/result.hpp"
#include "volute/codec/kept_grids.hpp"
#include "volute/grid/frame_source.hpp"
#include "volute/grid/grid_description.hpp"

namespace volute {

/// One grid of a file in the making.
struct BundledGrid {
  std::string name;
  std::optional<GridDescription> description{};
  std::filesystem::path file{};  ///< a .volute of this grid alone; none: the grid is empty
};

/// Puts .volute files of one grid each together as the grids of one, in their order. Segments are
/// copied byte for byte, tier by tier and in each grid by grid, so that a prefix of the file plays
/// all grids coarsely. One grid without a description gives the file as it is.
///
/// `kept`, which may be null, are grids that are stored as their bytes, behind all segments.
///
/// Where no grid has values, the file has its frames and times from `frames`, emptyFrames().
///
/// kInvalidArgument where grids have other frames than the first, two have one name, or none has
/// values and there are no `frames`.
/// @return the bytes of the new file.
[[nodiscard]] Result<std::uint64_t> bundle(const std::vector<BundledGrid>& grids,
                                           const FrameMetadata& fileMetadata,
                                           const std::filesystem::path& target, Progress& progress,
                                           KeptStore* kept = nullptr,
                                           FrameSource* frames = nullptr);

/// Whether a file of this grid alone needs to say more of it than its values. Without a description
/// its first voxel has the index 0, so that its leaves and tiles are others unless they begin
/// there.
/// @param cropped  it begins at another voxel than the cache's
bool wantsDescription(const GridDescription& grid, bool cropped = false);

/// Frames without anything in them.
std::unique_ptr<FrameSource> emptyFrames(const VolumeInfo& frames);

}  // namespace volute
