// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "volute/fds/smv_index.hpp"

namespace volute {

/// What became of a file that the index names.
enum class FdsFileState {
  kWhole,
  kMissing,
  kEmpty,      ///< not one whole frame yet
  kTruncated,  ///< ends within a frame
  kShort,      ///< has fewer frames than files of its kind for other meshes
  kDamaged,
};

/// "whole", "missing", ...
std::string_view nameOf(FdsFileState state);

/// A data file of a case, looked through to its end.
struct FdsFileCheck {
  std::filesystem::path path;
  std::string kind;  ///< for people: what it holds; files of one kind have the same times
  int mesh = 0;      ///< place in SmvIndex::meshes
  FdsFileState state = FdsFileState::kWhole;
  std::vector<double> times;  ///< of its whole frames [s]
  std::string reason;         ///< what is wrong with it; empty where nothing is
};

/// All slices, smoke and PLOT3D files that the index names, in its order; of these each frame's
/// markers are read, not its values. Of all other files that it names, at the end, only whether
/// they are there and not empty; a table of particles may be empty for a while.
std::vector<FdsFileCheck> checkFiles(const SmvIndex& index);

}  // namespace volute
