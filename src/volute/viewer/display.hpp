// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>

#include "volute/gl/gl_program.hpp"
#include "volute/image/colormap.hpp"

namespace volute {

/// How light becomes what a display shows.
struct DisplayLook {
  double exposure = 1;
  std::optional<ColorMap> map;  ///< of the first channel, 0..1 after the exposure
  Rgb background = Rgb::Zero();
  GLuint surfaces = 0;  ///< SurfaceDrawer's; 0: there are none
};

/// Draws a GlRenderer's texture, and the surfaces behind it, into the framebuffer that is bound.
class Display {
 public:
  [[nodiscard]] static Result<Display> create();

  void draw(GLuint picture, const DisplayLook& look, int width, int height);

 private:
  explicit Display(GlProgram program) : program_(std::move(program)) {}

  GlProgram program_;
  GlVertexArray nothing_;
  GlTexture colors_;
  GlObject<detail::destroySampler> smooth_;
  std::optional<ColorMap> map_;
};

}  // namespace volute
