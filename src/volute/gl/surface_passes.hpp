// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
#include <optional>
#include <span>

#include "volute/gl/gl_passes.hpp"
#include "volute/gl/gl_program.hpp"
#include "volute/gl/gl_rays.hpp"
#include "volute/gl/gl_scene.hpp"
#include "volute/gl/gl_triangles.hpp"
#include "volute/lighting/lamp.hpp"
#include "volute/render/surfaces.hpp"

namespace volute {

/// renderSurfaces()' twin: the nearest triangle on each pixel's ray by a tree of boxes, and what
/// lamps' light, attenuated by media and kept off by other triangles, sends back from there. And
/// the same for the walls of a mesh.
class SurfacePasses {
 public:
  /// Marches the media along these rays: their optical depths are in the fourth channel of the
  /// texture that it gives. Null where there are no media.
  using Attenuate = std::function<Result<GLuint>(const GlRays&)>;

  /// `scene.media` is not used: `attenuate` stands for them.
  [[nodiscard]] Result<SurfacePicture> draw(const Camera& camera, const SurfaceScene& scene,
                                            const Rgb& background, const Attenuate& attenuate,
                                            GlPasses& passes);

  /// `attenuate` marches the walls' media.
  [[nodiscard]] Result<SurfacePicture> drawWalls(const Camera& camera, const GlWalls& walls,
                                                 const Attenuate& attenuate, GlPasses& passes);

 private:
  /// Buffers of surfaces, which do not depend on the camera.
  struct Surfaces {
    TriangleScene scene;
    GlTriangles triangles;
    GlBuffer materials;
  };

  struct Walls {
    std::shared_ptr<const TetMesh> mesh;
    GlTriangles triangles;
  };

  struct Programs {
    GlProgram hit, shadow, light;
  };

  struct Targets {
    int width = 0, height = 0;
    GlTexture color{}, distances{}, normals{}, points{}, ways{}, ends{};
  };

  /// Those that are seen, or may be in a lamp's way.
  struct Occluders {
    const GlTriangles& triangles;
    GlTriangles::Sides sides;
  };

  Status prepare(const Camera& camera);
  Status prepareSurfaces(const TriangleScene& scene);
  Status prepareWalls(const std::shared_ptr<const TetMesh>& mesh);
  void look(const Camera& camera, const Occluders& seen, const GlBuffer& materials,
            const Rgb& ambient, GlPasses& passes, const char* what);
  void shade(const Lamp& lamp, std::span<const Occluders> occluders, GlPasses& passes,
             const char* what);
  Status light(const Lamp& lamp, const GlBuffer& materials, const Attenuate& attenuate,
               GlPasses& passes, const char* what);
  SurfacePicture readBack(const Rgb& background) const;

  std::optional<Surfaces> surfaces_;
  std::optional<Walls> walls_;
  Targets targets_;
  std::optional<Programs> programs_;
  Vec3 origin_ = Vec3::Zero();  ///< what the points are relative to [m]
};

}  // namespace volute
