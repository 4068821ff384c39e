// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "volute/camera/camera.hpp"
#include "volute/image/pixels.hpp"
#include "volute/media/field.hpp"

namespace volute {

/// Where a camera is at a time.
struct CameraKey {
  double time = 0;  ///< [s], of the scene
  Vec3 eye = Vec3::Zero();
  Vec3 target = Vec3::Zero();
};

/// A scene's camera object: a view and either a vertical field of view or the height of a
/// block-shaped view volume.
struct CameraDescription {
  View3 view;
  std::optional<double> fov;    ///< [degrees]
  std::optional<double> ortho;  ///< [m]
  std::optional<Pixels> size;
  std::string reason{};            ///< of one that nobody asked for: what it shows
  std::vector<CameraKey> keys{};   ///< its way, by ascending times; empty: it stays
  std::optional<double> aspect{};  ///< of its pictures' width and height, where a glTF states it

  /// The view at a time: through all keys, with one velocity of eye and target at each (cubics of
  /// Catmull and Rom over the keys' own times), at rest before the first and after the last.
  View3 viewAt(double time) const;
};

const FieldTable& cameraFields();

/// A scene's camera object, or the options that say the same.
[[nodiscard]] Result<CameraDescription> parseCamera(const nlohmann::json& json,
                                                    const FieldOrigin& origin);

/// A file that holds a camera object, or a scene with one; or a .glb or .gltf with one camera.
[[nodiscard]] Result<CameraDescription> readCamera(const std::string& file);

Camera makeCamera(const CameraDescription& description, const Pixels& size);

}  // namespace volute
