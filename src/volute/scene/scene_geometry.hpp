// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "volute/geometry/triangle_scene.hpp"
#include "volute/math/vec.hpp"
#include "volute/media/reading.hpp"

namespace volute {

/// An entry of a scene's "geometry".
struct SceneGeometry {
  std::string file;  ///< found from the scene file's folder
  Mat4 transform = Mat4::Identity();
};

/// A list of {"file", "transform", "up"}; "up" is "z" (the default) or "y", which turns the file's
/// +y upwards before the transform. Errors name the file and the path inside it.
[[nodiscard]] Result<std::vector<SceneGeometry>> parseGeometry(const nlohmann::json& json,
                                                               const std::string& file,
                                                               const std::string& path);

/// Reads all files into one.
[[nodiscard]] Result<TriangleScene> loadGeometry(const std::vector<SceneGeometry>& entries,
                                                 const Reading& reading);

}  // namespace volute
