// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>

#include "volute/gl/gl_smoke_method.hpp"
#include "volute/scene/scene_renderer.hpp"

namespace volute {

/// A renderer by OpenGL 4.5, without a display, in a context of its own. Its pictures agree with
/// the CPU's within 2e-5 of their maximum. kUnsupported, in one sentence, where this machine has no
/// OpenGL 4.5.
/// @param hardwareOnly  not by a driver that draws on the CPU
[[nodiscard]] Result<std::unique_ptr<SceneRenderer>> createGlRenderer(
    bool hardwareOnly, GlSmokeMethod method = GlSmokeMethod::kAuto);

}  // namespace volute
