// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/surface_passes.hpp"

#include <cmath>
#include <limits>

#include "volute/gl/glsl_sources.hpp"
#include "volute/gl/texel.hpp"

namespace volute {
namespace {

using Sides = GlTriangles::Sides;

constexpr float kNoSurface = 3e38F;
constexpr float kLift = 2e-6F;  ///< of a shadow's ray, as surfaces_shadow.glsl has it
constexpr const char* kGeometry = "geometry";
constexpr const char* kWalls = "walls";

Result<GlProgram> computeProgram(std::vector<ShaderPart> parts) {
  const ShaderStage stage{GL_COMPUTE_SHADER, std::move(parts)};
  return GlProgram::link({&stage, 1});
}

void bindLamp(const GlProgram& program, const Lamp& lamp, const Vec3& origin) {
  program.set("lampIsSun", lamp.kind == Lamp::Kind::kSun ? 1 : 0);
  program.set("lampPlace", Vec3(lamp.position - origin));
  program.set("lampDirection", lamp.direction);
  program.set("lampCosine", static_cast<float>(lamp.coneCosine));
  program.set("lampEdge", static_cast<float>(lamp.edge));
  program.set("lampRadius", static_cast<float>(lamp.radius));
  program.set("lampIntensity", Vec3(lamp.intensity));
}

void bindImage(GLuint unit, const GlTexture& texture, GLenum access, GLenum format) {
  glBindImageTexture(unit, texture.name(), 0, GL_FALSE, 0, access, format);
}

void bindTexture(const GlProgram& program, const char* name, GLuint unit, GLuint texture) {
  program.set(name, static_cast<int>(unit));
  glBindTextureUnit(unit, texture);
}

/// The boundary of a mesh, with fronts inwards.
std::vector<Triangle> wallsOf(const TetMesh& mesh) {
  std::vector<Triangle> walls;
  const auto points = mesh.vertices();
  for (const std::int32_t f : mesh.boundary()) {
    const TetFace& face = mesh.faces()[f];
    const auto [a, b, c] = face.vertices;
    Triangle wall{{points[a], points[b], points[c]}};
    const Vec3& inner = points[mesh.tets()[face.first / 4][face.first % 4]];
    if (wall.normal().dot(inner - points[a]) < 0)
      std::swap(wall.corners[1], wall.corners[2]);
    walls.push_back(wall);
  }
  return walls;
}

}  // namespace

Status SurfacePasses::prepare(const Camera& camera) {
  if (!programs_) {
    VOLUTE_ASSIGN(auto hit, computeProgram({{"ray.glsl", glsl::kRay},
                                            {"triangles.glsl", glsl::kTriangles},
                                            {"surfaces_hit.glsl", glsl::kSurfacesHit}}));
    VOLUTE_ASSIGN(auto shadow, computeProgram({{"triangles.glsl", glsl::kTriangles},
                                               {"lamp.glsl", glsl::kLamp},
                                               {"surfaces_shadow.glsl", glsl::kSurfacesShadow}}));
    VOLUTE_ASSIGN(auto light,
                  computeProgram({{"surfaces_light.glsl", "const float NOWHERE = 3e38;"},
                                  {"lamp.glsl", glsl::kLamp},
                                  {"surfaces_light.glsl", glsl::kSurfacesLight}}));
    programs_ = Programs{std::move(hit), std::move(shadow), std::move(light)};
  }
  if (targets_.width == camera.width() && targets_.height == camera.height())
    return {};
  targets_ = {camera.width(), camera.height()};
  for (GlTexture* texture : {&targets_.color, &targets_.normals, &targets_.points, &targets_.ways})
    *texture = makeTexture2d(GL_RGBA32F, targets_.width, targets_.height);
  for (GlTexture* texture : {&targets_.distances, &targets_.ends})
    *texture = makeTexture2d(GL_R32F, targets_.width, targets_.height);
  return {};
}

Status SurfacePasses::prepareSurfaces(const TriangleScene& scene) {
  // Scenes share their triangles: the same ones are at the same place.
  if (surfaces_ && surfaces_->scene.triangles().data() == scene.triangles().data())
    return {};
  surfaces_.reset();
  VOLUTE_ASSIGN(auto triangles, GlTriangles::make(scene));
  std::vector<Texel> materials;
  for (const Material& material : scene.materials()) {
    materials.push_back(texel(material.baseColor));
    materials.push_back(texel(material.emission));
  }
  surfaces_ = Surfaces{scene, std::move(triangles), makeBuffer(materials)};
  return {};
}

Status SurfacePasses::prepareWalls(const std::shared_ptr<const TetMesh>& mesh) {
  if (walls_ && walls_->mesh == mesh)
    return {};
  walls_.reset();
  VOLUTE_ASSIGN(auto triangles, GlTriangles::make(wallsOf(*mesh)));
  walls_ = Walls{mesh, std::move(triangles)};
  return {};
}

void SurfacePasses::look(const Camera& camera, const Occluders& seen, const GlBuffer& materials,
                         const Rgb& ambient, GlPasses& passes, const char* what) {
  const GlProgram& hit = programs_->hit;
  const GlTriangles& triangles = seen.triangles;
  passes.run("surfaces", what, [&] {
    GlLens lens;
    if (!camera.distortion().none())
      lens = lensDirections(camera);
    origin_ = pictureOrigin(camera, {&triangles.bounds, 1});
    bindRays(hit, camera, origin_, {.lens = lens.directions.name(), .rest = lens.rest.name()});
    triangles.bind(hit, origin_, seen.sides);
    hit.bindStorage("Normals", 3, triangles.normals);
    hit.set("smoothed", triangles.smooth ? 1 : 0);
    hit.bindStorage("Materials", 2, materials);
    hit.set("reach", static_cast<float>(triangles.reach));
    hit.set("ambient", Vec3(ambient));
    bindImage(0, targets_.color, GL_WRITE_ONLY, GL_RGBA32F);
    bindImage(1, targets_.distances, GL_WRITE_ONLY, GL_R32F);
    bindImage(2, targets_.normals, GL_WRITE_ONLY, GL_RGBA32F);
    bindImage(3, targets_.points, GL_WRITE_ONLY, GL_RGBA32F);
    runOver(hit, targets_.width, targets_.height);
  });
}

void SurfacePasses::shade(const Lamp& lamp, std::span<const Occluders> occluders, GlPasses& passes,
                          const char* what) {
  passes.run("shadows", what, [&] {
    bindLamp(programs_->shadow, lamp, origin_);
    programs_->shadow.set("lift", kLift);
    bindTexture(programs_->shadow, "normals", 0, targets_.normals.name());
    bindTexture(programs_->shadow, "points", 1, targets_.points.name());
    bindImage(0, targets_.ways, GL_READ_WRITE, GL_RGBA32F);
    bindImage(1, targets_.ends, GL_WRITE_ONLY, GL_R32F);
    for (const Occluders& some : occluders) {
      programs_->shadow.set("again", &some == occluders.data() ? 0 : 1);
      some.triangles.bind(programs_->shadow, origin_, some.sides);
      programs_->shadow.setExactly("lampInGeometry", Vec3(lamp.position - some.triangles.middle));
      runOver(programs_->shadow, targets_.width, targets_.height);
    }
  });
}

Status SurfacePasses::light(const Lamp& lamp, const GlBuffer& materials, const Attenuate& attenuate,
                            GlPasses& passes, const char* what) {
  GLuint passed = 0;
  if (attenuate) {
    VOLUTE_ASSIGN(passed, attenuate({.opaque = targets_.ends.name(),
                                     .lens = targets_.ways.name(),
                                     .origins = targets_.points.name(),
                                     .from = origin_}));
  }
  passes.run("light", what, [&] {
    const GlProgram& light = programs_->light;
    light.bindStorage("Materials", 2, materials);  // after the march has used the bindings
    bindLamp(light, lamp, origin_);
    bindTexture(light, "normals", 0, targets_.normals.name());
    bindTexture(light, "points", 1, targets_.points.name());
    bindTexture(light, "ways", 2, targets_.ways.name());
    bindTexture(light, "passed", 3, passed);
    light.set("passedGiven", passed ? 1 : 0);
    bindImage(0, targets_.color, GL_READ_WRITE, GL_RGBA32F);
    runOver(light, targets_.width, targets_.height);
  });
  return {};
}

SurfacePicture SurfacePasses::readBack(const Rgb& background) const {
  SurfacePicture picture;
  picture.color = Image(targets_.width, targets_.height, 3);
  const std::size_t pixels = picture.color.pixels.size() / 3;
  picture.depth.resize(pixels);
  std::vector<Texel> colors(pixels);
  glGetTextureImage(targets_.distances.name(), 0, GL_RED, GL_FLOAT,
                    static_cast<GLsizei>(pixels * sizeof(float)), picture.depth.data());
  glGetTextureImage(targets_.color.name(), 0, GL_RGBA, GL_FLOAT,
                    static_cast<GLsizei>(pixels * sizeof(Texel)), colors.data());
  for (std::size_t i = 0; i < pixels; ++i) {
    const bool met = picture.depth[i] < kNoSurface;
    picture.surfacePixels += met;
    if (!met)
      picture.depth[i] = std::numeric_limits<float>::infinity();
    for (int c = 0; c < 3; ++c)
      picture.color.pixels[3 * i + c] = met ? colors[i][c] : static_cast<float>(background[c]);
  }
  return picture;
}

Result<SurfacePicture> SurfacePasses::draw(const Camera& camera, const SurfaceScene& scene,
                                           const Rgb& background, const Attenuate& attenuate,
                                           GlPasses& passes) {
  VOLUTE_TRY(prepare(camera));
  VOLUTE_TRY(prepareSurfaces(scene.geometry));
  look(camera, {surfaces_->triangles, Sides::kBoth}, surfaces_->materials, scene.ambient, passes,
       kGeometry);
  const Occluders occluders[] = {{surfaces_->triangles, Sides::kBoth}};
  for (const Lamp& lamp : scene.lamps) {
    shade(lamp, occluders, passes, kGeometry);
    VOLUTE_TRY(light(lamp, surfaces_->materials, attenuate, passes, kGeometry));
  }
  SurfacePicture picture;
  passes.run("read back", [&] { picture = readBack(background); });
  return picture;
}

Result<SurfacePicture> SurfacePasses::drawWalls(const Camera& camera, const GlWalls& walls,
                                                const Attenuate& attenuate, GlPasses& passes) {
  VOLUTE_TRY(prepare(camera));
  VOLUTE_TRY(prepareWalls(walls.mesh));
  std::vector<Occluders> occluders{{walls_->triangles, Sides::kBack}};
  if (!walls.blocks.empty()) {
    VOLUTE_TRY(prepareSurfaces(walls.blocks));
    occluders.push_back({surfaces_->triangles, Sides::kBoth});
  }
  const GlBuffer materials =
      makeBuffer(std::vector<Texel>{texel(walls.color), texel(Rgb(Rgb::Zero()))});
  look(camera, {walls_->triangles, Sides::kFront}, materials, walls.ambient, passes, kWalls);
  for (const Lamp& lamp : walls.lamps) {
    shade(lamp, occluders, passes, kWalls);
    VOLUTE_TRY(light(lamp, materials, attenuate, passes, kWalls));
  }
  SurfacePicture picture;
  passes.run("read back", [&] { picture = readBack(Rgb::Zero()); });
  return picture;
}

}  // namespace volute
