// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "volute/geometry/triangle_scene.hpp"
#include "volute/render/billboard.hpp"
#include "volute/scene/reading.hpp"
#include "volute/scene/scene_lights.hpp"
#include "volute/scene/volume_layer.hpp"

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

/// 16 numbers, row-major: an affine transform that can be undone.
[[nodiscard]] Result<Mat4> parseTransform(const nlohmann::json& json, const std::string& file,
                                          const std::string& path);

/// The same of a volume, whose voxels stay at right angles: kUnsupported for a transform that
/// shears.
[[nodiscard]] Result<Placement> parsePlacement(const nlohmann::json& json, const std::string& file,
                                               const std::string& path);

/// Reads all files into one.
[[nodiscard]] Result<TriangleScene> loadGeometry(const std::vector<SceneGeometry>& entries,
                                                 const Reading& reading);

/// What SunScattering::shadows of fog under these suns is; empty where there is no geometry.
std::function<void(const Segment&, std::size_t, std::vector<Interval>&)> fogShadows(
    const TriangleScene& geometry, const std::vector<FogSun>& suns);

/// What stands between lamps and smoke; empty where there is no geometry.
Blocks blocksOf(const TriangleScene& geometry);

/// Stands for the triangles where computed light is kept.
std::string keyOf(const TriangleScene& geometry);

/// An entry of a scene's "billboards".
struct SceneBillboard {
  std::string file;  ///< of the volume
  Appearance appearance;
  BillboardOptions options;
};

/// A list of {"volume", "position", "size", "alpha", "emission", "extinction", "time", "rows"}.
[[nodiscard]] Result<std::vector<SceneBillboard>> parseBillboards(const nlohmann::json& json,
                                                                  const std::string& file,
                                                                  const std::string& path);

}  // namespace volute
