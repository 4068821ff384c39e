// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "volute/base/team.hpp"
#include "volute/codec/extract_source.hpp"
#include "volute/io/volume_sink.hpp"

namespace volute {

/// Grids of a .volute that are taken out of it together.
struct ExtractedGrids {
  std::vector<GridTarget> targets;  ///< what becomes of each
  std::vector<std::unique_ptr<FrameSource>> sources;  ///< of each; null: it is empty
  std::vector<std::shared_ptr<const VoluteReader>> readers;  ///< the same
  FrameMetadata fileMetadata;
  std::vector<int> positions;  ///< of the frames in the file, ascending
};

/// Opens the grids called `names`.
/// @param extraction  `region` is not used: whole grids are taken
[[nodiscard]] Result<ExtractedGrids> openGrids(const std::string& path,
                                               const std::vector<std::string>& names,
                                               const Extraction& extraction, bool partial,
                                               Reading& reading);

/// Where values go, made on rank 0 alone.
using MakeSink = std::function<Result<std::unique_ptr<CacheSink>>()>;

/// Hands all frames to the sink in order. The frames of a row of blocks are a unit of work for the
/// ranks; rank 0 writes. Collective.
/// @param sources  null ones give no values
/// @param positions  of the frames in the file
[[nodiscard]] Status extractFrames(const std::vector<std::unique_ptr<FrameSource>>& sources,
                                   const std::vector<int>& positions, const MakeSink& makeSink,
                                   Reading& reading, Team& team);

}  // namespace volute
