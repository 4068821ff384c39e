// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>

#include "volute/base/result.hpp"
#include "volute/geometry/triangle_scene.hpp"

namespace volute {

/// Writes triangles as a binary glTF file, whole or not at all: one primitive for each material
/// that is used, coordinates as floats. z is upwards in the mesh, y in the file, as
/// glTF has it.
[[nodiscard]] Status writeGlb(const std::filesystem::path& path, const TriangleMesh& mesh);

}  // namespace volute
