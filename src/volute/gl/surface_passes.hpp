// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
#include <optional>
#include <span>

#include "volute/geometry/triangle_scene.hpp"
#include "volute/gl/gl_passes.hpp"
#include "volute/gl/gl_program.hpp"
#include "volute/gl/gl_rays.hpp"
#include "volute/lighting/lamp.hpp"
#include "volute/render/surfaces.hpp"

namespace volute {

/// renderSurfaces()' twin: the nearest triangle on each pixel's ray by a tree of boxes, and what
/// lamps' light, attenuated by media and kept off by other triangles, sends back from there.
class SurfacePasses {
 public:
  /// Marches the media along these rays: their optical depths are in the fourth channel of the
  /// texture that it gives. Null where there are no media.
  using Attenuate = std::function<Result<GLuint>(const GlRays&)>;

  /// `scene.media` is not used: `attenuate` stands for them.
  [[nodiscard]] Result<SurfacePicture> draw(const Camera& camera, const SurfaceScene& scene,
                                            const Rgb& background, const Attenuate& attenuate,
                                            GlPasses& passes);

 private:
  /// What does not change with the camera.
  struct Triangles {
    Vec3 middle = Vec3::Zero();
    double reach = 0;  ///< [m] from the middle to the farthest corner
    GlBuffer nodes, corners, materials;
  };

  struct Targets {
    int width = 0, height = 0;
    GlTexture color{}, distances{}, normals{}, points{}, ways{}, ends{};
  };

  Status prepare(const Camera& camera, const TriangleScene& geometry);
  void look(const Camera& camera, const SurfaceScene& scene, GlPasses& passes);
  Status light(const Camera& camera, const Lamp& lamp, const Attenuate& attenuate,
               GlPasses& passes);
  void bindTriangles(const GlProgram& program, const Camera& camera) const;
  SurfacePicture readBack(const Rgb& background) const;

  TriangleScene geometry_;
  std::optional<Triangles> triangles_;
  Targets targets_;
  std::optional<GlProgram> hit_, shadow_, light_;
};

}  // namespace volute
