// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <map>
#include <memory>
#include <span>
#include <vector>

#include "volute/camera/camera.hpp"
#include "volute/gl/gl_program.hpp"
#include "volute/viewer/view_scene.hpp"

namespace volute {

/// Draws what is opaque in a ViewScene by rasterisation.
class SurfaceDrawer {
 public:
  [[nodiscard]] static Result<SurfaceDrawer> create();

  /// Before a camera without a lens. True if the scene has anything opaque.
  /// @param surfaces  false: its quads alone
  bool draw(const Camera& camera, const ViewScene& scene, bool surfaces = true);

  /// The same with surfaces that are known for each pixel.
  /// @param known  four a pixel, as ExactSurfaces::texels()
  /// @returns whether they are elsewhere than draw() had them, so that media before them change
  bool drawKnown(const Camera& camera, const ViewScene& scene, std::span<const float> known);

  /// Linear radiance and, in the fourth channel, ViewQuad::power; 0 where nothing is. Row 0 is the
  /// top. Of the last draw() or drawKnown().
  GLuint texture() const { return colors_.name(); }

  /// Along each pixel's ray [m], infinite where nothing is; shape (height, width).
  std::span<const float> depth() const { return depth_; }

 private:
  SurfaceDrawer(GlProgram triangles, GlProgram pictures, GlProgram known)
      : triangles_(std::move(triangles)),
        pictures_(std::move(pictures)),
        known_(std::move(known)) {}

  struct Kept {
    std::shared_ptr<const Image> picture;
    GlTexture texture;
    bool used = true;
  };

  void resize(int width, int height);
  void upload(const std::shared_ptr<const ViewSurfaces>& surfaces);
  GLuint textureOf(const std::shared_ptr<const Image>& picture);
  void look(const GlProgram& program, const Camera& camera) const;
  void begin(const Camera& camera, const Box3& bounds, const ViewScene& scene);
  void end(const Camera& camera, const ViewScene& scene);
  void drawQuads(const std::vector<ViewQuad>& quads);

  GlProgram triangles_, pictures_, known_;
  double farthest_ = 1;  ///< [m] along the view, that a parallel camera draws
  GlTexture colors_, distances_, nearest_;
  GlFramebuffer frame_;
  GlVertexArray corners_, nothing_;
  GlBuffer positions_, lights_;
  GlObject<detail::destroySampler> smooth_;
  std::shared_ptr<const ViewSurfaces> uploaded_;
  Box3 bounds_;  ///< of what is uploaded
  std::map<const Image*, Kept> kept_;
  std::vector<float> depth_;
  int width_ = 0, height_ = 0;
};

}  // namespace volute
