// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <filesystem>

#include "volute/base/result.hpp"
#include "volute/geometry/triangle_scene.hpp"

namespace volute {

/// Reads opaque surfaces: .glb and .gltf (glTF 2.0: the default scene's nodes, base color and
/// emissive factors; no textures, skins or morphs), .obj (with the Kd and Ke of its .mtl, linear)
/// and .vtp (polygons and strips), and .vdb and .nvdb (the first level set of one file, a
/// LevelSetSurface, with its upward axis). Coordinates stay as the file has them. Files that name
/// others may name those below their own folder alone.
///
/// .glb, .gltf and .vtp are read in a child process. kTooLarge when the triangles need more than
/// `maxMemory` bytes.
[[nodiscard]] Result<TriangleMesh> readSurfaces(const std::filesystem::path& path,
                                                std::uint64_t maxMemory = std::uint64_t{4} << 30);

/// Whether the name ends as one of these files does.
bool isSurfacePath(const std::filesystem::path& path);

}  // namespace volute
