// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <memory>

#include "volute/grid/frame_source.hpp"
#include "volute/io/frame_pattern.hpp"
#include "volute/io/lattice.hpp"
#include "volute/io/volume_sink.hpp"

namespace volute {

/// One file a frame. `output` is a frame pattern, a single file's name when there is one frame, or
/// a .pvd collection.
[[nodiscard]] Result<std::unique_ptr<FrameSink>> createLatticeSink(
    const std::filesystem::path& output, const VolumeInfo& info,
    std::unique_ptr<LatticeWriter> writer);

/// The same for all grids of a cache.
/// @param frames  their numbers
[[nodiscard]] Result<std::unique_ptr<CacheSink>> createLatticeCacheSink(
    const std::filesystem::path& output, const VolumeInfo& frames, std::vector<GridTarget> grids,
    FrameMetadata fileMetadata, std::vector<KeptTarget> kept,
    std::unique_ptr<LatticeWriter> writer);

/// The files of frames, with their numbers as those of the cache are written where the pattern has
/// such numbers.
/// @param files  what the cache's files say
std::vector<std::filesystem::path> framePaths(const FramePattern& pattern, const VolumeInfo& frames,
                                              const FrameMetadata& files);

}  // namespace volute
