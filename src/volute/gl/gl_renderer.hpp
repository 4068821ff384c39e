// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "volute/gl/gl_part.hpp"
#include "volute/render/render.hpp"
#include "volute/render/sign.hpp"
#include "volute/render/surfaces.hpp"

namespace volute {

/// render()'s twin on OpenGL 4.5: compute shaders go along the same rays through the same cells, in
/// float. Pictures agree with the reference within 2e-3 of the brightest pixel; what was measured
/// is in gl_renderer_test.cpp. Needs a current context all its life, in one thread.
class GlRenderer {
 public:
  [[nodiscard]] static Result<GlRenderer> create();

  GlRenderer(GlRenderer&&) noexcept;
  GlRenderer& operator=(GlRenderer&&) noexcept;
  ~GlRenderer();

  /// As volute::render(); `options.renderer` has no meaning. kTooLarge for what does not fit on
  /// the device, kUnsupported for what a part does not draw.
  [[nodiscard]] Result<Image> render(const Camera& camera, const GlScene& scene,
                                     const RenderOptions& options, Progress& progress,
                                     RenderStats* stats = nullptr,
                                     std::span<const float> opaqueDepth = {});

  /// The same without reading it back: texture() then holds the light towards the eye and, in its
  /// fourth channel, the optical depth.
  [[nodiscard]] Status draw(const Camera& camera, const GlScene& scene, GlQuantity quantity,
                            Progress& progress, std::span<const float> opaqueDepth = {});

  /// As renderSurfaces(), with these media in the place of the scene's. texture() stays, of
  /// whatever size the camera's picture is.
  [[nodiscard]] Result<SurfacePicture> surfaces(const Camera& camera, const SurfaceScene& scene,
                                                const GlScene& media, const Rgb& background,
                                                Progress& progress);

  /// The walls of a mesh, as lookAtWalls() sees them; black where there are none. texture() stays.
  [[nodiscard]] Result<SurfacePicture> walls(const Camera& camera, const GlWalls& walls,
                                             Progress& progress);

  /// Pixels of each sign, as signPixels() finds them; empty without signs.
  [[nodiscard]] Result<std::vector<SignPixel>> findSigns(const Camera& camera,
                                                         std::span<const Sign> signs,
                                                         std::span<const float> opaqueDepth);

  /// What is seen of the signs found last through what texture() holds, which must be their depths:
  /// each through exp(-power * depth). Black elsewhere.
  [[nodiscard]] Result<Image> signLight(std::span<const float> powers);

  GLuint texture() const;

  /// GlResources::counts, of ways of drawing that have been taken.
  const std::map<std::string, GlCounts>& counts() const;

  /// What the device did since the last call, and how long it took.
  std::vector<GlPassTime> takePasses();

 private:
  struct State;

  explicit GlRenderer(std::unique_ptr<State> state);

  std::unique_ptr<State> state_;
};

}  // namespace volute
