// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>

#include "volute/gl/gl_object.hpp"
#include "volute/gl/gl_program.hpp"
#include "volute/image/colormap.hpp"

namespace volute {

/// How light becomes what a display shows.
struct DisplayLook {
  double exposure = 1;
  bool filmic = false;          ///< ToneCurve::kFilmic; else light is clipped
  std::optional<ColorMap> map;  ///< of the first channel, 0..1 after the exposure
  Rgb background = Rgb::Zero();
  GLuint surfaces = 0;  ///< SurfaceDrawer's; 0: there are none
};

/// Draws a GlRenderer's texture, and the surfaces behind it, into the framebuffer that is bound.
/// What it drew last is kept, with 8 bits a channel: while only panels change it is copied.
class Display {
 public:
  [[nodiscard]] static Result<Display> create();

  /// @param version  another one where what is in `picture` or in the surfaces has changed
  void draw(GLuint picture, int version, const DisplayLook& look, int width, int height);

 private:
  explicit Display(GlProgram program) : program_(std::move(program)) {}

  bool isKept(GLuint picture, int version, const DisplayLook& look, int width, int height) const;
  void keep(GLuint picture, const DisplayLook& look);

  GlProgram program_;
  GlVertexArray nothing_;
  GlTexture colors_;
  GlObject<detail::destroySampler> smooth_;
  std::optional<ColorMap> map_;
  GlTexture kept_;  ///< what was drawn last, of this:
  GlFramebuffer frame_;
  GLuint picture_ = 0;
  int version_ = 0;
  DisplayLook look_;
  int width_ = 0, height_ = 0;
};

}  // namespace volute
