// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>

#include "volute/cli/field_options.hpp"
#include "volute/media/camera_file.hpp"

namespace volute::cli {

/// From --camera or --eye, --target, --up and --fov or --ortho; nothing when none of them is given.
[[nodiscard]] Result<std::optional<CameraDescription>> cameraOf(const Arguments& arguments);

}  // namespace volute::cli
