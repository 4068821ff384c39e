// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <vector>

#include "volute/gl/gl_device.hpp"
#include "volute/gl/gl_renderer.hpp"
#include "volute/gl/gl_snapshot.hpp"
#include "volute/scene/scene_renderer.hpp"

namespace volute {

/// OpenGL 4.5, without a display, in a context of its own. Agrees with the CPU as GlRenderer says.
class GlSceneRenderer final : public SceneRenderer {
 public:
  /// kUnsupported, in one sentence, where this machine has no OpenGL 4.5.
  [[nodiscard]] static Result<std::unique_ptr<GlSceneRenderer>> create(bool hardwareOnly,
                                                                       GlSmokeMethod method);

  std::string_view name() const override { return "gl"; }

  /// The device's name, and what it did, pass by pass.
  nlohmann::ordered_json stats() override;

 protected:
  Status begin(const View& view) override;
  Result<SurfacePicture> surfaces(const View& view, Progress& progress) override;
  Result<SurfaceView> walls(const View& view, std::size_t medium) override;
  Result<std::vector<SignPixel>> findSigns(const View& view) override;
  Result<Image> color(const View& view, const RenderOptions& options, Progress& progress,
                      RenderStats& stats) override;
  Result<Image> opticalDepth(const View& view, const RenderOptions& options, Progress& progress,
                             RenderStats& stats) override;
  Status addSigns(const View& view, std::span<const SignPixel> seen, const RenderOptions& options,
                  Progress& progress, Image& image) override;

 private:
  GlSceneRenderer(HeadlessGl gl, GlRenderer renderer, GlSmokeMethod method)
      : gl_(std::move(gl)), renderer_(std::move(renderer)), method_(method) {}

  HeadlessGl gl_;  // first, so that it ends last
  GlRenderer renderer_;
  GlSmokeMethod method_;
  std::vector<GlPassTime> passes_;
  GlScene scene_, natural_;  ///< of the picture that is being taken
};

}  // namespace volute
