// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/gl_rays.hpp"

#include <algorithm>
#include <limits>
#include <vector>

namespace volute {
namespace {

constexpr int kRayOpaqueUnit = 0, kRayLensUnit = 1, kRayOriginsUnit = 2;

}  // namespace

Vec3 rowStep(const Camera& camera) {
  const Vec3 down = camera.down() * camera.pixelSize();
  if (camera.isOrthographic())
    return down;
  const double skew = camera.intrinsics()(0, 1) * camera.pixelSize();
  return down - camera.right() * (skew * camera.pixelWidth());
}

Vec3 pictureOrigin(const Camera& camera, std::span<const Box3> bounds) {
  const auto nearest = [](const Box3& box, const Vec3& point) {
    return Vec3(point.cwiseMax(box.min).cwiseMin(box.max));
  };
  Vec3 best = camera.eye();
  double least = std::numeric_limits<double>::infinity();
  for (const Box3& one : bounds) {
    const Vec3 point = nearest(one, camera.eye());
    double worst = 0;
    for (const Box3& other : bounds) {
      const double size = other.size().norm();
      if (size > 0)  // and not infinite
        worst = std::max(worst, (nearest(other, point) - point).norm() / size);
    }
    if (point.allFinite() && worst < least) {
      least = worst;
      best = point;
    }
  }
  return best;
}

void bindRays(const GlProgram& program, const Camera& camera, const Vec3& origin,
              const GlRays& rays) {
  program.set("size", std::array{camera.width(), camera.height()});
  program.set("firstRow", 0);
  program.set("cuts", 0);
  program.setExactly("eyeFromOrigin", Vec3(camera.eye() - origin));
  program.setExactly("forward", camera.forward());
  program.setExactly("right", Vec3(camera.right() * camera.pixelWidth()));
  program.setExactly("down", rowStep(camera));
  program.setExactly("principal", camera.principalPoint());
  program.set("orthographic", camera.isOrthographic() ? 1 : 0);
  program.set("opaque", kRayOpaqueUnit);
  program.set("lens", kRayLensUnit);
  program.set("origins", kRayOriginsUnit);
  program.set("opaqueGiven", rays.opaque ? 1 : 0);
  program.set("lensGiven", rays.lens ? 1 : 0);
  program.set("originsGiven", rays.origins ? 1 : 0);
  glBindTextureUnit(kRayOpaqueUnit, rays.opaque);
  glBindTextureUnit(kRayLensUnit, rays.lens);
  glBindTextureUnit(kRayOriginsUnit, rays.origins ? rays.origins : rays.rest);
}

GlLens lensDirections(const Camera& camera) {
  std::vector<float> directions, rest;
  const std::size_t values = 4 * static_cast<std::size_t>(camera.width()) * camera.height();
  directions.reserve(values), rest.reserve(values);
  for (int y = 0; y < camera.height(); ++y) {
    for (int x = 0; x < camera.width(); ++x) {
      const Segment ray = camera.ray(x + 0.5, y + 0.5);
      for (int axis = 0; axis < 3; ++axis) {
        directions.push_back(static_cast<float>(ray.direction[axis]));
        rest.push_back(static_cast<float>(ray.direction[axis] - double{directions.back()}));
      }
      directions.push_back(ray.empty() ? 0.0F : 1.0F);
      rest.push_back(0);
    }
  }
  const auto textureOf = [&](const std::vector<float>& texels) {
    GlTexture texture = makeTexture2d(GL_RGBA32F, camera.width(), camera.height());
    glTextureSubImage2D(texture.name(), 0, 0, 0, camera.width(), camera.height(), GL_RGBA, GL_FLOAT,
                        texels.data());
    return texture;
  };
  return {textureOf(directions), textureOf(rest)};
}

void runOver(const GlProgram& program, int width, int height) {
  constexpr GLuint kGroup = 8;
  program.use();
  glDispatchCompute((static_cast<GLuint>(width) + kGroup - 1) / kGroup,
                    (static_cast<GLuint>(height) + kGroup - 1) / kGroup, 1);
  glMemoryBarrier(GL_ALL_BARRIER_BITS);
}

Status runInBands(const GlProgram& program, const Camera& camera, int rowsAtOnce,
                  Progress& progress) {
  for (int row = 0; row < camera.height(); row += rowsAtOnce) {
    if (progress.cancelled()) {
      return fail(ErrorCode::kCancelled, "stopped: {} of {} rows were rendered", row,
                  camera.height());
    }
    program.set("firstRow", row);
    const int rows = std::min(rowsAtOnce, camera.height() - row);
    runOver(program, camera.width(), rows);
    glFlush();
    progress.report("rendering", row + rows, camera.height());
  }
  return {};
}

}  // namespace volute
