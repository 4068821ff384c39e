// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "volute/camera/camera.hpp"
#include "volute/image/pixels.hpp"

namespace volute {

/// A scene's camera object: a view and either a vertical field of view or the height of a
/// block-shaped view volume.
struct CameraDescription {
  View3 view;
  std::optional<double> fov;    ///< [degrees]
  std::optional<double> ortho;  ///< [m]
  std::optional<Pixels> size;
};

/// {"eye": [x,y,z], "target": [x,y,z], "up": [x,y,z], "fov": degrees or "ortho": metres, "size":
/// [w,h]}; up and size may be missing. Errors name the file and the path inside it.
[[nodiscard]] Result<CameraDescription> parseCamera(const nlohmann::json& json,
                                                    const std::string& file,
                                                    const std::string& path);

/// A file that holds a camera object, or a scene with one.
[[nodiscard]] Result<CameraDescription> readCamera(const std::string& file);

/// kInvalidArgument where eye and target coincide, or the field of view or the height is out of
/// range; `where` begins the sentence.
[[nodiscard]] Status checkView(const CameraDescription& camera, const std::string& where);

Camera makeCamera(const CameraDescription& description, const Pixels& size);

}  // namespace volute
