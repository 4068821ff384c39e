// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>

#include "volute/base/result.hpp"
#include "volute/gl/gl_smoke_method.hpp"
#include "volute/report/report.hpp"
#include "volute/scene/scene_renderer.hpp"

namespace volute::cli {

/// A renderer by OpenGL, without a display. kUnsupported, in one sentence, where this machine or
/// build has no OpenGL 4.5.
[[nodiscard]] Result<std::unique_ptr<SceneRenderer>> openGlRenderer(bool hardwareOnly,
                                                                    GlSmokeMethod method);

/// What `volute info --gl` says.
[[nodiscard]] Result<Report> describeGl();

/// True where `--renderer auto` may ask for OpenGL: this machine has graphics hardware.
bool glIsLikely();

}  // namespace volute::cli
