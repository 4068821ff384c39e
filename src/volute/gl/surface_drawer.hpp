// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <map>
#include <memory>
#include <span>
#include <vector>

#include "volute/camera/camera.hpp"
#include "volute/gl/gl_program.hpp"
#include "volute/image/image.hpp"

namespace volute {

/// Opaque triangles, seen where their corners go round anticlockwise, with the light that they send
/// back already found at their corners.
struct GlSurfaces {
  std::vector<float> corners;  ///< [m], 9 numbers a triangle
  std::vector<float> colors;   ///< linear RGB radiance, 9 numbers a triangle

  void add(const GlSurfaces& more) {
    corners.insert(corners.end(), more.corners.begin(), more.corners.end());
    colors.insert(colors.end(), more.colors.begin(), more.colors.end());
  }
};

/// A flat picture in space: a sign, or what a camera of a capture saw.
struct GlQuad {
  Vec3 corner = Vec3::Zero();            ///< its top left [m]
  Vec3 right = Vec3::UnitX();            ///< along its rows, as long as they are [m]
  Vec3 down = -Vec3::UnitZ();            ///< along its columns [m]
  std::shared_ptr<const Image> picture;  ///< linear RGB
  /// It is seen through the picture's transmittance to this power.
  double power = 1;
  bool bothSides = false;  ///< else only by who sees `right` go to the right
};

/// Draws opaque triangles and flat pictures by rasterisation.
class SurfaceDrawer {
 public:
  [[nodiscard]] static Result<SurfaceDrawer> create();

  /// Before a camera without a lens. True if there is anything opaque.
  /// @param surfaces  are uploaded where they are not those of the last time; may be null
  /// @param visible  false: `quads` alone are drawn
  bool draw(const Camera& camera, const std::shared_ptr<const GlSurfaces>& surfaces,
            std::span<const GlQuad> quads, bool visible = true);

  /// The same with surfaces that are known for each pixel.
  /// @param known  four a pixel: linear radiance, and how far along its ray [m]
  /// @returns whether they are elsewhere than draw() had them, so that media before them change
  bool drawKnown(const Camera& camera, std::span<const GlQuad> quads, std::span<const float> known);

  /// Linear radiance and, in the fourth channel, GlQuad::power; 0 where nothing is. Row 0 is the
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
  void upload(const std::shared_ptr<const GlSurfaces>& surfaces);
  GLuint textureOf(const std::shared_ptr<const Image>& picture);
  void look(const GlProgram& program, const Camera& camera) const;
  void begin(const Camera& camera, const Box3& bounds, std::span<const GlQuad> quads);
  void end(const Camera& camera, std::span<const GlQuad> quads);
  void drawQuads(std::span<const GlQuad> quads);

  GlProgram triangles_, pictures_, known_;
  double farthest_ = 1;  ///< [m] along the view, that a parallel camera draws
  GlTexture colors_, distances_, nearest_;
  GlFramebuffer frame_;
  GlVertexArray corners_, nothing_;
  GlBuffer positions_, lights_;
  GlObject<detail::destroySampler> smooth_;
  std::shared_ptr<const GlSurfaces> uploaded_;
  Box3 bounds_;  ///< of what is uploaded
  std::map<const Image*, Kept> kept_;
  std::vector<float> depth_;
  int width_ = 0, height_ = 0;
};

}  // namespace volute
