// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/display.hpp"

#include <vector>

#include "volute/gl/glsl_sources.hpp"

namespace volute {

namespace viewerGlsl {
extern const char* const kDisplay;
}  // namespace viewerGlsl

namespace {

constexpr int kColors = 256;
constexpr int kPictureUnit = 0, kColorsUnit = 1, kSurfacesUnit = 2;

void fillColors(GLuint texture, ColorMap map) {
  std::vector<float> texels;
  for (int i = 0; i < kColors; ++i) {
    const Rgb color = displayColor(map, i / (kColors - 1.0));
    for (int c = 0; c < 3; ++c) texels.push_back(static_cast<float>(color[c]));
  }
  glTextureSubImage2D(texture, 0, 0, 0, kColors, 1, GL_RGB, GL_FLOAT, texels.data());
}

}  // namespace

Result<Display> Display::create() {
  const ShaderStage stages[] = {{GL_VERTEX_SHADER, {{"screen.glsl", glsl::kScreen}}},
                                {GL_FRAGMENT_SHADER, {{"display.glsl", viewerGlsl::kDisplay}}}};
  VOLUTE_ASSIGN(auto program, GlProgram::link(stages));
  Display display(std::move(program));
  GLuint name = 0;
  glCreateVertexArrays(1, &name);
  display.nothing_ = GlVertexArray(name);
  glCreateSamplers(1, &name);
  glSamplerParameteri(name, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glSamplerParameteri(name, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glSamplerParameteri(name, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glSamplerParameteri(name, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  display.smooth_ = GlObject<detail::destroySampler>(name);
  display.colors_ = makeTexture2d(GL_RGB32F, kColors, 1);
  fillColors(display.colors_.name(), ColorMap::kInferno);
  display.map_ = ColorMap::kInferno;
  return display;
}

bool Display::isKept(GLuint picture, int version, const DisplayLook& look, int width,
                     int height) const {
  return picture_ == picture && version_ == version && width_ == width && height_ == height &&
         look_.exposure == look.exposure && look_.filmic == look.filmic && look_.map == look.map &&
         look_.surfaces == look.surfaces && (look_.background == look.background).all();
}

void Display::draw(GLuint picture, int version, const DisplayLook& look, int width, int height) {
  GLint target = 0;
  glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &target);
  glDisable(GL_SCISSOR_TEST);  // copies mind it, too
  if (width != width_ || height != height_) {
    kept_ = makeTexture2d(GL_RGBA8, width, height);
    GLuint name = 0;
    glCreateFramebuffers(1, &name);
    frame_ = GlFramebuffer(name);
    glNamedFramebufferTexture(name, GL_COLOR_ATTACHMENT0, kept_.name(), 0);
  }
  if (!isKept(picture, version, look, width, height)) {
    picture_ = picture, version_ = version, look_ = look, width_ = width, height_ = height;
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, frame_.name());
    keep(picture, look);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, static_cast<GLuint>(target));
  }
  glBlitNamedFramebuffer(frame_.name(), static_cast<GLuint>(target), 0, 0, width, height, 0, 0,
                         width, height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
}

/// Into the framebuffer that is bound, all of it.
void Display::keep(GLuint picture, const DisplayLook& look) {
  if (look.map && look.map != map_) {
    fillColors(colors_.name(), *look.map);
    map_ = look.map;
  }
  program_.use();
  program_.set("picture", kPictureUnit);
  program_.set("colors", kColorsUnit);
  program_.set("background", Vec3(look.background));
  program_.set("exposure", static_cast<float>(look.exposure));
  program_.set("mapped", look.map ? 1 : 0);
  program_.set("tone", look.filmic ? 1 : 0);
  program_.set("surfaces", kSurfacesUnit);
  program_.set("opaque", look.surfaces ? 1 : 0);
  // Not smoothed: its power has edges. Some texture in any case, or a rasteriser on the CPU
  // compiles the program twice.
  glBindTextureUnit(kSurfacesUnit, look.surfaces ? look.surfaces : picture);
  glBindTextureUnit(kPictureUnit, picture);
  glBindTextureUnit(kColorsUnit, colors_.name());
  glBindSampler(kPictureUnit, smooth_.name());
  glBindSampler(kColorsUnit, smooth_.name());
  glBindVertexArray(nothing_.name());
  glDisable(GL_BLEND);
  glDisable(GL_DEPTH_TEST);
  glViewport(0, 0, width_, height_);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glBindSampler(kPictureUnit, 0);
  glBindSampler(kColorsUnit, 0);
}

}  // namespace volute
