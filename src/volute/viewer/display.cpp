// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/display.hpp"

#include <array>
#include <cmath>
#include <vector>

#include "volute/gl/glsl_sources.hpp"

namespace volute {

namespace viewerGlsl {
extern const char* const kDisplay;
}  // namespace viewerGlsl

namespace {

constexpr int kColors = 256;
constexpr int kPictureUnit = 0, kColorsUnit = 1, kSurfacesUnit = 2, kOtherUnit = 3,
              kOtherSurfacesUnit = 4, kViewUnit = 5;

/// A view is sampled by light on a scale that is linear up to kViewDark and logarithmic above.
constexpr int kViewSide = 64;
constexpr double kViewDark = 0.0028, kViewBright = 64;

void fillColors(GLuint texture, ColorMap map) {
  std::vector<float> texels;
  for (int i = 0; i < kColors; ++i) {
    const Rgb color = displayColor(map, i / (kColors - 1.0));
    for (int c = 0; c < 3; ++c) texels.push_back(static_cast<float>(color[c]));
  }
  glTextureSubImage2D(texture, 0, 0, 0, kColors, 1, GL_RGB, GL_FLOAT, texels.data());
}

GlTexture sampled(const ViewTransform& view) {
  std::array<float, kViewSide> light{};
  for (int i = 0; i < kViewSide; ++i) {
    const double place = i / (kViewSide - 1.0) * std::log2(kViewBright / kViewDark + 1);
    light[i] = static_cast<float>(kViewDark * (std::exp2(place) - 1));
  }
  std::vector<float> values;
  for (const float blue : light)
    for (const float green : light)
      for (const float red : light) values.insert(values.end(), {red, green, blue});
  view.apply(values);
  GlTexture texture = makeTexture3d(GL_RGB16F, kViewSide, kViewSide, kViewSide);
  glTextureParameteri(texture.name(), GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTextureParameteri(texture.name(), GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  for (const GLenum axis : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_R})
    glTextureParameteri(texture.name(), axis, GL_CLAMP_TO_EDGE);
  glTextureSubImage3D(texture.name(), 0, 0, 0, 0, kViewSide, kViewSide, kViewSide, GL_RGB, GL_FLOAT,
                      values.data());
  return texture;
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

bool Display::isKept(GLuint picture, int version, const DisplayLook& look) const {
  return picture_ == picture && version_ == version && look_.exposure == look.exposure &&
         look_.tone == look.tone && look_.view == look.view && look_.map == look.map &&
         look_.surfaces == look.surfaces && look_.other == look.other &&
         (look_.background == look.background).all();
}

bool Display::Kept::resize(const DisplaySize& other) {
  if (size == other)
    return false;
  size = other;
  colors = makeTexture2d(GL_RGBA8, size.width, size.height);
  GLuint name = 0;
  glCreateFramebuffers(1, &name);
  frame = GlFramebuffer(name);
  glNamedFramebufferTexture(name, GL_COLOR_ATTACHMENT0, colors.name(), 0);
  return true;
}

void Display::Kept::copyTo(GLuint target, const DisplaySize& other) const {
  glBlitNamedFramebuffer(frame.name(), target, 0, 0, size.width, size.height, 0, 0, other.width,
                         other.height, GL_COLOR_BUFFER_BIT, size == other ? GL_NEAREST : GL_LINEAR);
}

void Display::prepare() {
  constexpr DisplaySize kSmall{3, 3};  // not powers of two, for which there may be other programs
  if (prepared_)
    return;
  prepared_ = true;
  const GlTexture dark = makeTexture2d(GL_RGBA32F, kSmall.width, kSmall.height);
  draw(dark.name(), 0, {}, kSmall, {2 * kSmall.width, 2 * kSmall.height});
  picture_ = 0;
}

void Display::draw(GLuint picture, int version, const DisplayLook& look, const DisplaySize& own,
                   const DisplaySize& window) {
  GLint bound = 0;
  glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &bound);
  const auto target = static_cast<GLuint>(bound);
  glDisable(GL_SCISSOR_TEST);  // copies mind it, too
  const bool resized = kept_.resize(own);
  const bool other = resized || !isKept(picture, version, look);
  if (other) {
    picture_ = picture, version_ = version, look_ = look;
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, kept_.frame.name());
    keep(picture, look);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, target);
  }
  if (own == window) {
    kept_.copyTo(target, window);
    return;
  }
  if (enlarged_.resize(window) || other)
    kept_.copyTo(enlarged_.frame.name(), window);
  enlarged_.copyTo(target, window);
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
  program_.set("mapped", look.other.picture ? 2 : look.map ? 1 : 0);
  program_.set("span", static_cast<float>(look.other.span));
  program_.set("other", kOtherUnit);
  program_.set("otherSurfaces", kOtherSurfacesUnit);
  program_.set("otherOpaque", look.other.surfaces ? 1 : 0);
  const auto some = [&](GLuint texture) { return texture ? texture : picture; };
  glBindTextureUnit(kOtherUnit, some(look.other.picture));
  glBindTextureUnit(kOtherSurfacesUnit, some(look.other.surfaces));
  if (look.view && look.view != viewOf_) {
    view_ = sampled(*look.view);
    viewOf_ = look.view;
  }
  program_.set("tone", look.view ? 4 : static_cast<int>(look.tone));
  program_.set("view", kViewUnit);
  program_.set("viewScale", Vec3(1 / kViewDark, 1 / std::log2(kViewBright / kViewDark + 1), 0));
  program_.set("viewSide", static_cast<float>(kViewSide));
  glBindTextureUnit(kViewUnit, viewOf_ ? view_.name() : 0);
  program_.set("surfaces", kSurfacesUnit);
  program_.set("opaque", look.surfaces ? 1 : 0);
  // Not smoothed: its power has edges. Some texture in any case, or a rasteriser on the CPU
  // compiles the program twice.
  glBindTextureUnit(kSurfacesUnit, some(look.surfaces));
  glBindTextureUnit(kPictureUnit, picture);
  glBindTextureUnit(kColorsUnit, colors_.name());
  glBindSampler(kPictureUnit, smooth_.name());
  glBindSampler(kColorsUnit, smooth_.name());
  glBindVertexArray(nothing_.name());
  glDisable(GL_BLEND);
  glDisable(GL_DEPTH_TEST);
  glViewport(0, 0, kept_.size.width, kept_.size.height);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glBindSampler(kPictureUnit, 0);
  glBindSampler(kColorsUnit, 0);
}

}  // namespace volute
