// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <vector>

#include "bench/gl_cases.hpp"
#include "volute/gl/gl_renderer.hpp"

namespace volute::bench {

/// Draws the cases of `volute bench gl` by OpenGL. Needs a current context all its life.
class GlCaseDrawer {
 public:
  explicit GlCaseDrawer(GlRenderer& renderer) : renderer_(renderer) {}

  /// The first frame, read back.
  [[nodiscard]] Result<Image> picture(const GlCase& one, int width, int height);

  /// One frame, which stays on the device; but what is seen of signs is read back.
  [[nodiscard]] Status frame(const GlCase& one, const Camera& camera, int frame);

  /// As GlRenderer::takePasses().
  std::vector<GlPassTime> takePasses();

 private:
  [[nodiscard]] Result<std::vector<float>> findSigns(const GlCase& one, const Camera& camera);
  [[nodiscard]] Result<Image> signLight(const GlCase& one);

  GlRenderer& renderer_;
  GlPasses passes_;  ///< of what the renderer does not draw
  Progress quiet_;
};

}  // namespace volute::bench
