// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <optional>

#include "volute/gl/depth_splat.hpp"
#include "volute/gl/gl_scene.hpp"
#include "volute/gl/scene_shader.hpp"
#include "volute/gl/tet_projector.hpp"

namespace volute {

/// How this scene's smoke is drawn, once kAuto is decided.
GlSmokeMethod smokeMethod(const GlScene& scene, const Camera& camera, GlQuantity quantity);

/// Smoke that is alone in its picture, by other ways than the march. Keeps what it made for the
/// last mesh.
class SmokePasses {
 public:
  /// Fills an RGBA32F texture of the camera's size with the smoke's light and its optical depth.
  /// @param method  kSplat or kProject
  /// @param opaque  as DepthSplat::add(); `opaqueDepth` holds the same
  [[nodiscard]] Status draw(const Camera& camera, const GlSmoke& smoke, GlSmokeMethod method,
                            std::span<const float> opaqueDepth, GLuint opaque, GLuint picture,
                            GlPasses& passes);

  /// Of the mesh that was drawn last by kProject.
  std::optional<TetProjectorCounts> projected() const {
    return projector_ ? std::optional(projector_->counts()) : std::nullopt;
  }

 private:
  Status splat(const Camera& camera, const GlSmoke& smoke, GLuint opaque, GLuint picture,
               GlPasses& passes);
  Status project(const Camera& camera, const GlSmoke& smoke, std::span<const float> opaqueDepth,
                 GLuint picture, GlPasses& passes);

  std::shared_ptr<const TetLocator> locator_;
  std::optional<DepthSplat> splat_;
  std::optional<TetProjector> projector_;
  std::optional<GlProgram> resolve_;
};

}  // namespace volute
