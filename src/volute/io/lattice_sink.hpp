// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <memory>

#include "volute/grid/frame_source.hpp"
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

}  // namespace volute
