// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <filesystem>

#include "volute/base/progress.hpp"
#include "volute/base/result.hpp"

namespace volute {

/// A made-up fire in a hall, as a .pvd series or an FDS case: see hallSmoke().
struct HallFiles {
  std::uint32_t seed = 1;
  double cell = 0.4;    ///< size of the mesh's cells [m]
  int steps = 31;       ///< one .vtu file each, or frame of the FDS case
  double interval = 5;  ///< between steps [s]
};

/// `target` ends in .pvd or .smv; the other files are beside it.
[[nodiscard]] Status writeHall(const HallFiles& files, const std::filesystem::path& target,
                               Progress& progress);

/// A ball of smoke over the floor of a box of 6 x 6 x 4 m, as one .vtu file: what shows how lamps
/// light smoke and its shadow.
[[nodiscard]] Status writeBall(const std::filesystem::path& target, std::uint32_t seed);

}  // namespace volute
