// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/camera/camera.hpp"
#include "volute/gl/gl_object.hpp"
#include "volute/gl/gl_passes.hpp"
#include "volute/gl/gl_program.hpp"
#include "volute/tetmesh/tet_mesh.hpp"

namespace volute {

/// The framebuffer that tets are blended into.
enum class TetTarget {
  kFloat32,
  kFloat16,
  kFixed8,
  kFixed8Dithered,  ///< transmittances rounded at random (Staubli et al. 2005, equations 12 and 13)
};

enum class TetBlend { kBackToFront, kFrontToBack };

struct TetProjectorOptions {
  TetTarget target = TetTarget::kFloat32;
  TetBlend blend = TetBlend::kBackToFront;
  /// Cells end at opaque depths that they reach; else only those whose nearest vertex is behind
  /// them are left out, by the depth test.
  bool cutAtWalls = true;
};

/// Counts of a TetProjector's work.
struct TetProjectorCounts {
  std::int64_t sorts = 0;    ///< and projections; none while the eye stays
  std::int64_t uploads = 0;  ///< of vertices, their smoke, and indices
  std::int64_t pictures = 0;
  std::int64_t triangles = 0;  ///< of the last picture
};

/// Smoke by the paper's projected tetrahedra (Staubli et al. 2005, section 4): vertex and fragment
/// shaders, blending and textures of buffers, which OpenGL 3.3 has. Sorted and projected on the
/// CPU, once for each eye; turning and zooming costs nothing but the drawing, new smoke the
/// vertices' values. Where the paper interpolates a tet's front and back over its triangles, each
/// pixel finds where its ray passes: triangles cover what the rasteriser's grid makes of them, and
/// thick cells in which it is a little off would count twice or not at all. Needs the same current
/// context all its life.
class TetProjector {
 public:
  /// kTooLarge for a mesh that the device's textures of buffers do not hold.
  [[nodiscard]] static Result<TetProjector> create(std::shared_ptr<const TetMesh> mesh);

  TetProjector(TetProjector&&) noexcept;
  TetProjector& operator=(TetProjector&&) noexcept;
  ~TetProjector();

  /// Extinction [1/m], one for each vertex, and the radiance of infinitely thick smoke, RGB for
  /// each vertex or empty: black.
  void setSmoke(std::span<const float> extinction, std::span<const float> source);

  /// texture() then holds the smoke's light and, in its fourth channel, what it lets through. One
  /// ray for each pixel, up to `opaqueDepth` [m] along it (empty: to the end). kUnsupported for
  /// cameras with a lens.
  [[nodiscard]] Status draw(const Camera& camera, std::span<const float> opaqueDepth,
                            const TetProjectorOptions& options, GlPasses& passes);

  GLuint texture() const;

  /// The texture's values, four for each pixel.
  std::vector<float> read() const;

  const TetProjectorCounts& counts() const;

 private:
  struct State;

  explicit TetProjector(std::unique_ptr<State> state);

  std::unique_ptr<State> state_;
};

}  // namespace volute
