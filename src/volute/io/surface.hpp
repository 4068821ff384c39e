// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>

#include "volute/base/result.hpp"
#include "volute/geometry/triangle_scene.hpp"

namespace volute {

/// What a plug-in for files of surfaces offers. Used inside a child process (ReaderProcess),
/// because damaged files may crash such libraries.
struct SurfacePlugin {
  Result<TriangleMesh> (*read)(const std::filesystem::path& file);
};

}  // namespace volute
