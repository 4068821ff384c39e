// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <filesystem>

#include "volute/base/progress.hpp"
#include "volute/base/result.hpp"
#include "volute/image/pixels.hpp"

namespace volute {

/// What to write of a made-up valley.
struct ValleyFiles {
  std::uint32_t seed = 1;
  Pixels size{640, 360};
  int frames = 1;  ///< more than one: a flight
  int mapSize = 64;
  bool geometry = false;  ///< valley.glb too: a height every metre as triangles
};

/// Writes fogmap.png and color.exr, depth.exr, camera.json, or for a flight color_%04d.png,
/// depth_%04d.exr, camera_%04d.json, into a folder, which is made where it is missing.
[[nodiscard]] Status writeValley(const ValleyFiles& files, const std::filesystem::path& folder,
                                 Progress& progress);

}  // namespace volute
