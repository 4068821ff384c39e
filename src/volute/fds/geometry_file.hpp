// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string_view>
#include <vector>

#include "volute/base/result.hpp"

namespace volute {

/// The kind by which SmvIndex::others lists files of geometry.
inline constexpr std::string_view kFdsWallsKind = "walls made of triangles";

/// Walls made of triangles (&GEOM): closed bodies, whose triangles go round anticlockwise as seen
/// from the gas.
struct FdsGeometry {
  std::vector<std::array<float, 3>> vertices;          ///< [m]
  std::vector<std::array<std::int32_t, 3>> triangles;  ///< places in `vertices`
  std::vector<std::int32_t> surfaces;  ///< of each triangle: its place in SmvIndex::surfaces
  bool moves = false;                  ///< others that come or move are in the file, too
};

/// What stands still in a .ge file of version 2 (geom.f90, WRITE_GEOM and OUTGEOM, as FDS writes it
/// since 2015). Triangles of vertices that are not there, and vertices that are no numbers, are
/// kInvalidData; other versions are kUnsupported.
[[nodiscard]] Result<FdsGeometry> readGeometryFile(const std::filesystem::path& path);

}  // namespace volute
