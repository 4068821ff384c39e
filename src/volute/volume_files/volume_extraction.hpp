// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "volute/base/team.hpp"
#include "volute/grid/copy_frames.hpp"
#include "volute/grid/region.hpp"
#include "volute/grid/select_frames.hpp"
#include "volute/io/reading.hpp"
#include "volute/report/report.hpp"

namespace volute {

/// What to take out of a file.
struct ExtractionRequest {
  std::string fields{};  ///< grids of a .volute, "density,flame", or the source of an FDS case
  FrameRange frames{};
  std::optional<Region> region{};           ///< of a .volute
  int level = 0;                            ///< of a .volute: the resolution is divided by 2^level
  std::optional<double> framesPerSecond{};  ///< of a .volute, instead of its own times
  bool partial = false;                     ///< a damaged .volute is read as far as it is intact
  std::vector<std::string> taken{};         ///< names of other outputs, which none may have
};

/// Receives what was written, after each output. Collective.
using Extracted = std::function<Status(const Report&)>;

/// Whether a target's name has a place for the name of a grid, {grid}, or the number of a mesh,
/// {mesh}: then it is a pattern of several outputs.
bool namesEachGrid(const std::string& target);
bool namesEachMesh(const std::string& target);

/// An error where a target's name has a {word} that nothing is filled in for: another than `known`.
[[nodiscard]] Status checkWords(const std::string& target, std::string_view known = "{grid}");

/// Such a name with that of a grid in place of {grid}.
std::string nameOfGrid(std::string target, const std::string& grid);

/// Takes grids out of a .volute: several to .vdb files, which hold all, with what the cache says of
/// them, or one to a file of any format. The frames of a row of blocks are a unit of work for the
/// ranks. Collective.
[[nodiscard]] Status extractVolute(const std::string& path, const std::string& target,
                                   const ExtractionRequest& request, const Extracted& extracted,
                                   Reading& reading, Team& team);

/// Takes voxels of extinction [1/m] out of an FDS case, obstructions zero: all meshes together, or
/// each on its own where the target names each. Meshes without smoke are left out with a remark.
[[nodiscard]] Status extractFds(const std::string& path, const std::string& target,
                                const ExtractionRequest& request, const Extracted& extracted,
                                Reading& reading);

}  // namespace volute
