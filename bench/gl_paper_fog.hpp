// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>

#include "bench/baselines/paper_walk.hpp"
#include "volute/camera/camera.hpp"
#include "volute/gl/gl_object.hpp"
#include "volute/gl/gl_passes.hpp"
#include "volute/gl/gl_program.hpp"
#include "volute/image/image.hpp"

namespace volute::bench {

/// White fog of a decomposed map, seen from within its slab of heights: what Table 3 of Giroud and
/// Biri 2010 is measured with. All details are drawn (mu = 1).
struct PaperPicture {
  std::shared_ptr<const PaperFog> fog;
  double cell = 1;             ///< [m], of the map, whose corner is x = y = 0
  double bottom = 0, top = 1;  ///< [m], the slab; the eye is in it
  bool deconstructed = false;  ///< PaperFog::deconstructed(), else undeconstructed()
};

/// In double, on all threads. The light towards the eye, before black.
Image byCpu(const PaperPicture& picture, const Camera& camera);

/// The same walks in a compute shader, in float. Needs a current context all its life.
class GlPaperFog {
 public:
  /// kUnsupported for degrees above 2 and more than 3 levels, kInvalidData where the shader does
  /// not compile.
  [[nodiscard]] static Result<GlPaperFog> make(const PaperPicture& picture);

  /// Leaves light and optical depth on the device.
  void draw(const Camera& camera, GlPasses& passes);

  /// The same, read back.
  Image render(const Camera& camera, GlPasses& passes);

 private:
  GlPaperFog(PaperPicture picture, GlProgram program)
      : picture_(std::move(picture)), program_(std::move(program)) {}

  PaperPicture picture_;
  GlProgram program_;
  GlBuffer grids_;
  GlTexture target_;
  int width_ = 0, height_ = 0;
};

}  // namespace volute::bench
