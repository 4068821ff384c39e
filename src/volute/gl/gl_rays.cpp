// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/gl_rays.hpp"

#include <vector>

namespace volute {
namespace {

constexpr int kOpaqueUnit = 0, kLensUnit = 1, kOriginsUnit = 2;

}  // namespace

Vec3 rowStep(const Camera& camera) {
  const Vec3 down = camera.down() * camera.pixelSize();
  if (camera.isOrthographic())
    return down;
  const double skew = camera.intrinsics()(0, 1) * camera.pixelSize();
  return down - camera.right() * (skew * camera.pixelWidth());
}

void bindRays(const GlProgram& program, const Camera& camera, const GlRays& rays) {
  program.set("size", std::array{camera.width(), camera.height()});
  program.set("firstRow", 0);
  program.set("forward", camera.forward());
  program.set("right", Vec3(camera.right() * camera.pixelWidth()));
  program.set("down", rowStep(camera));
  program.set("principal", std::array{static_cast<float>(camera.principalPoint().x()),
                                      static_cast<float>(camera.principalPoint().y())});
  program.set("orthographic", camera.isOrthographic() ? 1 : 0);
  program.set("opaque", kOpaqueUnit);
  program.set("lens", kLensUnit);
  program.set("origins", kOriginsUnit);
  program.set("opaqueGiven", rays.opaque ? 1 : 0);
  program.set("lensGiven", rays.lens ? 1 : 0);
  program.set("originsGiven", rays.origins ? 1 : 0);
  glBindTextureUnit(kOpaqueUnit, rays.opaque);
  glBindTextureUnit(kLensUnit, rays.lens);
  glBindTextureUnit(kOriginsUnit, rays.origins);
}

GlTexture lensDirections(const Camera& camera) {
  std::vector<float> texels;
  texels.reserve(4 * static_cast<std::size_t>(camera.width()) * camera.height());
  for (int y = 0; y < camera.height(); ++y) {
    for (int x = 0; x < camera.width(); ++x) {
      const Segment ray = camera.ray(x + 0.5, y + 0.5);
      for (int axis = 0; axis < 3; ++axis)
        texels.push_back(static_cast<float>(ray.direction[axis]));
      texels.push_back(ray.empty() ? 0.0F : 1.0F);
    }
  }
  GlTexture lens = makeTexture2d(GL_RGBA32F, camera.width(), camera.height());
  glTextureSubImage2D(lens.name(), 0, 0, 0, camera.width(), camera.height(), GL_RGBA, GL_FLOAT,
                      texels.data());
  return lens;
}

void runOver(const GlProgram& program, int width, int height) {
  constexpr GLuint kGroup = 8;
  program.use();
  glDispatchCompute((static_cast<GLuint>(width) + kGroup - 1) / kGroup,
                    (static_cast<GLuint>(height) + kGroup - 1) / kGroup, 1);
  glMemoryBarrier(GL_ALL_BARRIER_BITS);
}

}  // namespace volute
