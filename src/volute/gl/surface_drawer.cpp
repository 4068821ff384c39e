// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/surface_drawer.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "volute/gl/glsl_sources.hpp"

namespace volute {

namespace {

constexpr float kNearest = 0.01F;    ///< [m]
constexpr float kElsewhere = 1e-3F;  ///< of their distance, that surfaces are off

Result<GlProgram> linkProgram(bool pictures) {
  const ShaderPart define{"define", pictures ? "#define PICTURE\n" : ""};
  const ShaderStage stages[] = {
      {GL_VERTEX_SHADER, {define, {"surface_vertex.glsl", glsl::kSurfaceVertex}}},
      {GL_FRAGMENT_SHADER, {define, {"surface_fragment.glsl", glsl::kSurfaceFragment}}}};
  return GlProgram::link(stages);
}

/// A picture with smaller ones of itself.
GlTexture pictureTexture(const Image& picture) {
  const int larger = std::max(picture.width, picture.height);
  GLuint name = 0;
  glCreateTextures(GL_TEXTURE_2D, 1, &name);
  glTextureStorage2D(name, std::bit_width(static_cast<unsigned>(larger)), GL_RGBA16F, picture.width,
                     picture.height);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTextureSubImage2D(name, 0, 0, 0, picture.width, picture.height, GL_RGB, GL_FLOAT,
                      picture.pixels.data());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  glGenerateTextureMipmap(name);
  return GlTexture(name);
}

/// How far from the eye, at most, anything is [m].
double farthestOf(const Camera& camera, const Box3& bounds, std::span<const GlQuad> quads) {
  Box3 all = bounds;
  for (const GlQuad& quad : quads) {
    for (const double across : {0.0, 1.0}) {
      for (const double below : {0.0, 1.0})
        all.extend(quad.corner + across * quad.right + below * quad.down);
    }
  }
  const Vec3 least = (all.min - camera.eye()).cwiseAbs(),
             most = (all.max - camera.eye()).cwiseAbs();
  return 1.01 * std::max(least.cwiseMax(most).norm(), 1.0);
}

}  // namespace

Result<SurfaceDrawer> SurfaceDrawer::create() {
  VOLUTE_ASSIGN(auto triangles, linkProgram(false));
  VOLUTE_ASSIGN(auto pictures, linkProgram(true));
  const ShaderStage stages[] = {
      {GL_VERTEX_SHADER, {{"screen.glsl", glsl::kScreen}}},
      {GL_FRAGMENT_SHADER, {{"surface_known.glsl", glsl::kSurfaceKnown}}}};
  VOLUTE_ASSIGN(auto known, GlProgram::link(stages));
  SurfaceDrawer drawer(std::move(triangles), std::move(pictures), std::move(known));
  GLuint names[2] = {};
  glCreateVertexArrays(2, names);
  drawer.corners_ = GlVertexArray(names[0]);
  drawer.nothing_ = GlVertexArray(names[1]);
  for (const GLuint place : {0U, 1U}) {
    glEnableVertexArrayAttrib(names[0], place);
    glVertexArrayAttribFormat(names[0], place, 3, GL_FLOAT, GL_FALSE, 0);
    glVertexArrayAttribBinding(names[0], place, place);
  }
  GLuint sampler = 0;
  glCreateSamplers(1, &sampler);
  glSamplerParameteri(sampler, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  glSamplerParameteri(sampler, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glSamplerParameteri(sampler, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glSamplerParameteri(sampler, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  drawer.smooth_ = GlObject<detail::destroySampler>(sampler);
  return drawer;
}

void SurfaceDrawer::resize(int width, int height) {
  if (width == width_ && height == height_)
    return;
  width_ = width, height_ = height;
  colors_ = makeTexture2d(GL_RGBA32F, width, height);
  distances_ = makeTexture2d(GL_R32F, width, height);
  nearest_ = makeTexture2d(GL_DEPTH_COMPONENT32F, width, height);
  GLuint name = 0;
  glCreateFramebuffers(1, &name);
  frame_ = GlFramebuffer(name);
  glNamedFramebufferTexture(name, GL_COLOR_ATTACHMENT0, colors_.name(), 0);
  glNamedFramebufferTexture(name, GL_COLOR_ATTACHMENT1, distances_.name(), 0);
  glNamedFramebufferTexture(name, GL_DEPTH_ATTACHMENT, nearest_.name(), 0);
  constexpr GLenum kTargets[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
  glNamedFramebufferDrawBuffers(name, 2, kTargets);
}

void SurfaceDrawer::upload(const std::shared_ptr<const GlSurfaces>& surfaces) {
  if (surfaces == uploaded_)
    return;
  uploaded_ = surfaces;
  if (!surfaces)
    return;
  bounds_ = Box3();
  for (std::size_t i = 0; i < surfaces->corners.size(); i += 3)
    bounds_.extend(Vec3(surfaces->corners[i], surfaces->corners[i + 1], surfaces->corners[i + 2]));
  positions_ = makeBuffer(std::span(surfaces->corners));
  lights_ = makeBuffer(std::span(surfaces->colors));
  constexpr GLsizei kStride = 3 * sizeof(float);
  glVertexArrayVertexBuffer(corners_.name(), 0, positions_.name(), 0, kStride);
  glVertexArrayVertexBuffer(corners_.name(), 1, lights_.name(), 0, kStride);
}

GLuint SurfaceDrawer::textureOf(const std::shared_ptr<const Image>& picture) {
  auto found = kept_.find(picture.get());
  if (found == kept_.end())
    found = kept_.emplace(picture.get(), Kept{picture, pictureTexture(*picture)}).first;
  found->second.used = true;
  return found->second.texture.name();
}

void SurfaceDrawer::look(const GlProgram& program, const Camera& camera) const {
  program.use();
  program.set("eye", camera.eye());
  program.set("right", camera.right());
  program.set("down", camera.down());
  program.set("forward", camera.forward());
  const double halfWidth = 0.5 * camera.width() * camera.pixelWidth();
  const double halfHeight = 0.5 * camera.height() * camera.pixelSize();
  const bool parallel = camera.isOrthographic();
  program.set("lens", Vec3(halfWidth, halfHeight, parallel ? 1 / (4 * farthest_) : kNearest));
  program.set("parallel", parallel ? 1 : 0);
  const Vec2& principal = camera.principalPoint();
  program.set("middle", Vec3(2 * principal.x() / camera.width() - 1,
                             2 * principal.y() / camera.height() - 1, 0));
  program.set("power", 1.0F);
}

void SurfaceDrawer::drawQuads(std::span<const GlQuad> quads) {
  glBindVertexArray(nothing_.name());
  glBindSampler(0, smooth_.name());
  pictures_.set("picture", 0);
  for (auto& [image, kept] : kept_) kept.used = false;
  for (const GlQuad& quad : quads) {
    if (!quad.picture || quad.picture->channels != 3)
      continue;
    glBindTextureUnit(0, textureOf(quad.picture));
    pictures_.set("corner", quad.corner);
    pictures_.set("alongRight", quad.right);
    pictures_.set("alongDown", quad.down);
    pictures_.set("power", static_cast<float>(quad.power));
    (quad.bothSides ? glDisable : glEnable)(GL_CULL_FACE);
    glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
  }
  glBindSampler(0, 0);
  std::erase_if(kept_, [](const auto& entry) { return !entry.second.used; });
}

/// @param bounds  of what will be drawn besides the quads
void SurfaceDrawer::begin(const Camera& camera, const Box3& bounds, std::span<const GlQuad> quads) {
  resize(camera.width(), camera.height());
  farthest_ = farthestOf(camera, bounds, quads);
  glBindFramebuffer(GL_FRAMEBUFFER, frame_.name());
  glViewport(0, 0, width_, height_);
  glDisable(GL_BLEND);
  glDisable(GL_SCISSOR_TEST);
  glEnable(GL_DEPTH_TEST);
  glDepthMask(GL_TRUE);
  glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  glDepthFunc(GL_GREATER);
  glFrontFace(GL_CW);  // rows go down
  constexpr float kNothing[4] = {}, kFar[4] = {std::numeric_limits<float>::infinity()};
  constexpr float kDepth = 0;
  glClearNamedFramebufferfv(frame_.name(), GL_COLOR, 0, kNothing);
  glClearNamedFramebufferfv(frame_.name(), GL_COLOR, 1, kFar);
  glClearNamedFramebufferfv(frame_.name(), GL_DEPTH, 0, &kDepth);
}

void SurfaceDrawer::end(const Camera& camera, std::span<const GlQuad> quads) {
  look(pictures_, camera);
  glFrontFace(GL_CCW);  // whoever reads a picture sees its corners go round the other way
  drawQuads(quads);
  glDisable(GL_CULL_FACE);
  glDisable(GL_DEPTH_TEST);
  glDepthFunc(GL_LESS);
  glClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
  depth_.resize(static_cast<std::size_t>(width_) * height_);
  glGetTextureImage(distances_.name(), 0, GL_RED, GL_FLOAT,
                    static_cast<GLsizei>(depth_.size() * sizeof(float)), depth_.data());
}

bool SurfaceDrawer::draw(const Camera& camera, const std::shared_ptr<const GlSurfaces>& surfaces,
                         std::span<const GlQuad> quads, bool visible) {
  const bool triangles = visible && surfaces;
  const bool any = triangles || !quads.empty();
  upload(surfaces);
  if (!any)
    return false;
  begin(camera, triangles ? bounds_ : Box3(), quads);
  if (triangles) {
    look(triangles_, camera);
    glBindVertexArray(corners_.name());
    glEnable(GL_CULL_FACE);
    glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(surfaces->corners.size() / 3));
  }
  end(camera, quads);
  return true;
}

bool SurfaceDrawer::drawKnown(const Camera& camera, std::span<const GlQuad> quads,
                              std::span<const float> known) {
  const GlTexture texels = makeTexture2d(GL_RGBA32F, camera.width(), camera.height());
  glTextureSubImage2D(texels.name(), 0, 0, 0, camera.width(), camera.height(), GL_RGBA, GL_FLOAT,
                      known.data());
  const std::vector<float> before = depth_;
  begin(camera, bounds_, quads);
  look(known_, camera);
  known_.set("known", 0);
  glBindTextureUnit(0, texels.name());
  glBindVertexArray(nothing_.name());
  glDisable(GL_CULL_FACE);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  end(camera, quads);
  if (before.size() != depth_.size())
    return true;
  for (std::size_t i = 0; i < before.size(); ++i) {
    const float near = std::min(before[i], depth_[i]), far = std::max(before[i], depth_[i]);
    if (far > (1 + kElsewhere) * near)
      return true;
  }
  return false;
}

}  // namespace volute
