// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>

#include "volute/media/camera_file.hpp"

namespace volute {

/// The one camera of a glTF 2.0 file's scene (.gltf, .glb), turned from its y upwards to z upwards
/// as its geometry is. Nothing but the file's JSON is read. kInvalidData names the cameras where
/// there is not just one; kUnsupported of one that an animation moves.
[[nodiscard]] Result<CameraDescription> readGltfCamera(const std::string& file);

}  // namespace volute
