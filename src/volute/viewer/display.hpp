// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>

#include "volute/gl/gl_object.hpp"
#include "volute/gl/gl_program.hpp"
#include "volute/image/colormap.hpp"
#include "volute/image/picture_style.hpp"

namespace volute {

/// How light becomes what a display shows.
struct DisplayLook {
  double exposure = 1;
  ToneCurve tone = ToneCurve::kNone;    ///< not kAgx
  const ViewTransform* view = nullptr;  ///< instead of a tone curve
  std::optional<ColorMap> map;          ///< of the first channel, 0..1 after the exposure
  Rgb background = Rgb::Zero();
  GLuint surfaces = 0;  ///< SurfaceDrawer's; 0: there are none

  /// Another picture: its difference from this one is shown, in the map's colours.
  struct Other {
    GLuint picture = 0, surfaces = 0;
    int version = 0;
    double span = 1;  ///< the difference of the last colour, after the exposure

    bool operator==(const Other&) const = default;
  };

  Other other{};  ///< without a picture: none
};

/// Of a picture or of a window [pixels].
struct DisplaySize {
  int width = 0, height = 0;

  bool operator==(const DisplaySize&) const = default;
};

/// Draws a GlRenderer's texture, and the surfaces behind it, into the framebuffer that is bound.
/// What it drew last is kept, with 8 bits a channel: while only panels change it is copied. Where
/// it is drawn smaller than the window it is enlarged afterwards, so that the tone curve, which
/// costs a rasteriser on the CPU most, is not computed for each of the window's pixels.
class Display {
 public:
  [[nodiscard]] static Result<Display> create();

  /// Draws nothing that is seen: a rasteriser on the CPU compiles programs when they first draw,
  /// and this is better done while a file is opened.
  void prepare();

  /// @param version  another one where what is in `picture` or in the surfaces has changed
  /// @param own  as large as it is drawn before it is enlarged: at most the window's size
  void draw(GLuint picture, int version, const DisplayLook& look, const DisplaySize& own,
            const DisplaySize& window);

 private:
  /// The picture that was drawn last, to be copied.
  struct Kept {
    GlTexture colors;
    GlFramebuffer frame;
    DisplaySize size;

    /// True: it is empty now.
    bool resize(const DisplaySize& other);
    void copyTo(GLuint target, const DisplaySize& other) const;
  };

  explicit Display(GlProgram program) : program_(std::move(program)) {}

  bool isKept(GLuint picture, int version, const DisplayLook& look) const;
  void keep(GLuint picture, const DisplayLook& look);

  GlProgram program_;
  GlVertexArray nothing_;
  GlTexture colors_;
  GlObject<detail::destroySampler> smooth_;
  std::optional<ColorMap> map_;
  GlTexture view_;  ///< of viewOf_, sampled
  const ViewTransform* viewOf_ = nullptr;
  bool prepared_ = false;
  Kept kept_, enlarged_;
  GLuint picture_ = 0;
  int version_ = 0;
  DisplayLook look_;
};

}  // namespace volute
