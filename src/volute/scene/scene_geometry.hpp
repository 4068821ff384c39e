// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>
#include <vector>

#include "volute/geometry/triangle_scene.hpp"
#include "volute/io/reading.hpp"
#include "volute/media/field.hpp"

namespace volute {

/// The axis of a file that is upwards.
enum class UpAxis {
  kFormat,  ///< y of .glb and .gltf, as glTF says; z of the others
  kY,
  kZ,
};

/// An entry of a scene's "geometry".
struct SceneGeometry {
  std::string file;                   ///< found from the scene file's folder
  Mat4 transform = Mat4::Identity();  ///< of the file with z upwards
  UpAxis up = UpAxis::kFormat;
};

const FieldTable& geometryFields();

/// Reads all files into one.
[[nodiscard]] Result<TriangleScene> loadGeometry(const std::vector<SceneGeometry>& entries,
                                                 const Reading& reading);

}  // namespace volute
