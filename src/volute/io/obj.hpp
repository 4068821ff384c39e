// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <filesystem>

#include "volute/base/result.hpp"
#include "volute/geometry/triangle_scene.hpp"

namespace volute {

/// A Wavefront .obj file: v, f (also with texture and normal numbers, and counted from the end),
/// usemtl and mtllib; of materials Kd and Ke, taken as linear. Polygons are cut into a fan from
/// their first corner. Other statements are skipped. Errors name the line.
[[nodiscard]] Result<TriangleMesh> readObj(const std::filesystem::path& path,
                                           std::uint64_t maxMemory);

}  // namespace volute
