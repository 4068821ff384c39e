// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/smoke_passes.hpp"

#include "volute/gl/gl_rays.hpp"
#include "volute/gl/glsl_sources.hpp"

namespace volute {
namespace {

std::shared_ptr<const TetMesh> meshOf(const GlSmoke& smoke) {
  return {smoke.locator, &smoke.locator->mesh()};
}

/// In sizes of the mesh: from farther eyes the rasterised ways, whose places are floats from the
/// eye, are off by more than 5e-4 of the brightest, and smoke is marched.
constexpr double kFarthestSizes = 300;

bool isFar(const TetMesh& mesh, const Camera& camera) {
  const Box3 box = mesh.bounds();
  return (camera.eye() - box.centre()).norm() > kFarthestSizes * box.size().norm();
}

}  // namespace

GlSmokeMethod smokeMethod(const GlScene& scene, const Camera& camera, GlQuantity quantity) {
  if (scene.smokes.size() != 1 || scene.media() != 1 || !camera.distortion().none() ||
      isFar(scene.smokes[0].locator->mesh(), camera))
    return GlSmokeMethod::kMarch;
  if (scene.smokeMethod == GlSmokeMethod::kProject)
    return GlSmokeMethod::kProject;
  const bool black = scene.smokes[0].source.empty() || quantity == GlQuantity::kOpticalDepth;
  return black && scene.smokeMethod != GlSmokeMethod::kMarch ? GlSmokeMethod::kSplat
                                                             : GlSmokeMethod::kMarch;
}

Status SmokePasses::draw(const Camera& camera, const GlSmoke& smoke, GlSmokeMethod method,
                         std::span<const float> opaqueDepth, GLuint opaque, GLuint picture,
                         GlPasses& passes) {
  if (locator_ != smoke.locator) {
    splat_.reset();
    projector_.reset();
    locator_ = smoke.locator;
  }
  return method == GlSmokeMethod::kProject
             ? project(camera, smoke, opaqueDepth, picture, passes)
             : splat(camera, smoke, opaqueDepth.empty() ? 0 : opaque, picture, passes);
}

Status SmokePasses::splat(const Camera& camera, const GlSmoke& smoke, GLuint opaque, GLuint picture,
                          GlPasses& passes) {
  if (!splat_) {
    VOLUTE_ASSIGN(splat_,
                  passes.run("upload", "smoke", [&] { return DepthSplat::create(meshOf(smoke)); }));
  }
  if (!splat_->holds(smoke.extinction))
    passes.run("upload", "smoke", [&] { splat_->setExtinction(smoke.extinction); });
  Status drawn;
  passes.run("splat", "smoke", [&] {
    const float nothing[4] = {};
    glClearTexImage(picture, 0, GL_RGBA, GL_FLOAT, nothing);
    drawn = splat_->add(camera, opaque, picture);
  });
  return drawn;
}

Status SmokePasses::project(const Camera& camera, const GlSmoke& smoke,
                            std::span<const float> opaqueDepth, GLuint picture, GlPasses& passes) {
  if (!projector_) {
    VOLUTE_ASSIGN(projector_, passes.run("upload", "smoke",
                                         [&] { return TetProjector::create(meshOf(smoke)); }));
  }
  if (!resolve_) {
    const ShaderStage stage{GL_COMPUTE_SHADER, {{"resolve.glsl", glsl::kResolve}}};
    VOLUTE_ASSIGN(resolve_, GlProgram::link({&stage, 1}));
  }
  projector_->setSmoke(smoke.extinction, smoke.source);
  VOLUTE_TRY(projector_->draw(camera, opaqueDepth, {}, passes));
  passes.run("resolve", "smoke", [&] {
    resolve_->set("blended", 0);
    glBindTextureUnit(0, projector_->texture());
    glBindImageTexture(0, picture, 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
    runOver(*resolve_, camera.width(), camera.height());
  });
  return {};
}

}  // namespace volute
