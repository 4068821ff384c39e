// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/surface_passes.hpp"

#include <cmath>
#include <limits>

#include "volute/gl/box_tree.hpp"
#include "volute/gl/glsl_sources.hpp"

namespace volute {
namespace {

using Texel = std::array<float, 4>;

constexpr float kNowhere = 3e38F;
constexpr float kLift = 2e-6F;  ///< of a shadow's ray, as surfaces_shadow.glsl has it

Texel texel(const Vec3& value, float last = 0) {
  return {static_cast<float>(value.x()), static_cast<float>(value.y()),
          static_cast<float>(value.z()), last};
}

Result<GlProgram> computeProgram(std::vector<ShaderPart> parts) {
  const ShaderStage stage{GL_COMPUTE_SHADER, std::move(parts)};
  return GlProgram::link({&stage, 1});
}

void bindLamp(const GlProgram& program, const Lamp& lamp, const Vec3& eye) {
  program.set("lampIsSun", lamp.kind == Lamp::Kind::kSun ? 1 : 0);
  program.set("lampPlace", Vec3(lamp.position - eye));
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

}  // namespace

Status SurfacePasses::prepare(const Camera& camera, const TriangleScene& geometry) {
  if (!hit_) {
    VOLUTE_ASSIGN(hit_, computeProgram({{"ray.glsl", glsl::kRay},
                                        {"triangles.glsl", glsl::kTriangles},
                                        {"surfaces_hit.glsl", glsl::kSurfacesHit}}));
    VOLUTE_ASSIGN(shadow_, computeProgram({{"triangles.glsl", glsl::kTriangles},
                                           {"lamp.glsl", glsl::kLamp},
                                           {"surfaces_shadow.glsl", glsl::kSurfacesShadow}}));
    VOLUTE_ASSIGN(light_, computeProgram({{"surfaces_light.glsl", "const float NOWHERE = 3e38;"},
                                          {"lamp.glsl", glsl::kLamp},
                                          {"surfaces_light.glsl", glsl::kSurfacesLight}}));
  }
  if (targets_.width != camera.width() || targets_.height != camera.height()) {
    targets_ = {camera.width(), camera.height()};
    for (GlTexture* texture :
         {&targets_.color, &targets_.normals, &targets_.points, &targets_.ways})
      *texture = makeTexture2d(GL_RGBA32F, targets_.width, targets_.height);
    for (GlTexture* texture : {&targets_.distances, &targets_.ends})
      *texture = makeTexture2d(GL_R32F, targets_.width, targets_.height);
  }
  // Scenes share their triangles: the same ones are at the same place.
  if (triangles_ && geometry_.triangles().data() == geometry.triangles().data())
    return {};
  Triangles made;
  made.middle = geometry.bounds().centre();
  std::vector<Box3> boxes;
  for (const Triangle& triangle : geometry.triangles()) {
    Box3 box;
    for (const Vec3& corner : triangle.corners) {
      box.extend(corner - made.middle);
      made.reach = std::max(made.reach, (corner - made.middle).norm());
    }
    boxes.push_back(box);
  }
  const BoxTree tree(boxes);
  std::vector<std::array<double, 4>> corners;
  std::vector<Texel> materials;
  for (const std::int32_t item : tree.items) {
    const Triangle& triangle = geometry.triangles()[item];
    for (const Vec3& corner : triangle.corners) {
      const Vec3 at = corner - made.middle;
      corners.push_back({at.x(), at.y(), at.z(), static_cast<double>(triangle.material)});
    }
  }
  for (const Material& material : geometry.materials()) {
    materials.push_back(texel(material.baseColor));
    materials.push_back(texel(material.emission));
  }
  GLint64 most = 0;
  glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &most);
  if (static_cast<std::int64_t>(corners.size() * sizeof(corners[0])) > most) {
    return fail(ErrorCode::kTooLarge,
                "{} triangles do not fit in the graphics device's buffers of {} MiB; render with "
                "--renderer cpu",
                boxes.size(), most >> 20);
  }
  made.nodes = makeBuffer(std::span<const BoxTree::Node>(tree.nodes));
  made.corners = makeBuffer(std::span<const std::array<double, 4>>(corners));
  made.materials = makeBuffer(std::span<const Texel>(materials));
  triangles_ = std::move(made);
  geometry_ = geometry;
  return {};
}

void SurfacePasses::bindTriangles(const GlProgram& program, const Camera& camera) const {
  program.bindStorage("Nodes", 0, triangles_->nodes);
  program.bindStorage("Corners", 1, triangles_->corners);
  program.bindStorage("Materials", 2, triangles_->materials);
  program.setExactly("eyeInGeometry", Vec3(camera.eye() - triangles_->middle));
}

void SurfacePasses::look(const Camera& camera, const SurfaceScene& scene, GlPasses& passes) {
  passes.run("surfaces", "geometry", [&] {
    GlTexture lens;
    if (!camera.distortion().none())
      lens = lensDirections(camera);
    bindRays(*hit_, camera, {.lens = lens.name()});
    bindTriangles(*hit_, camera);
    hit_->setExactly("exactForward", camera.forward());
    hit_->setExactly("exactRight", Vec3(camera.right() * camera.pixelWidth()));
    hit_->setExactly("exactDown", rowStep(camera));
    hit_->setExactly("exactPrincipal", camera.principalPoint());
    hit_->set("reach", static_cast<float>(triangles_->reach));
    hit_->set("ambient", Vec3(scene.ambient));
    bindImage(0, targets_.color, GL_WRITE_ONLY, GL_RGBA32F);
    bindImage(1, targets_.distances, GL_WRITE_ONLY, GL_R32F);
    bindImage(2, targets_.normals, GL_WRITE_ONLY, GL_RGBA32F);
    bindImage(3, targets_.points, GL_WRITE_ONLY, GL_RGBA32F);
    runOver(*hit_, targets_.width, targets_.height);
  });
}

Status SurfacePasses::light(const Camera& camera, const Lamp& lamp, const Attenuate& attenuate,
                            GlPasses& passes) {
  passes.run("shadows", "geometry", [&] {
    bindTriangles(*shadow_, camera);
    bindLamp(*shadow_, lamp, camera.eye());
    shadow_->set("lift", kLift);
    bindTexture(*shadow_, "normals", 0, targets_.normals.name());
    bindTexture(*shadow_, "points", 1, targets_.points.name());
    bindImage(0, targets_.ways, GL_WRITE_ONLY, GL_RGBA32F);
    bindImage(1, targets_.ends, GL_WRITE_ONLY, GL_R32F);
    runOver(*shadow_, targets_.width, targets_.height);
  });
  GLuint passed = 0;
  if (attenuate) {
    VOLUTE_ASSIGN(passed,
                  attenuate({targets_.ends.name(), targets_.ways.name(), targets_.points.name()}));
  }
  passes.run("light", "geometry", [&] {
    bindLamp(*light_, lamp, camera.eye());
    light_->bindStorage("Materials", 2, triangles_->materials);
    bindTexture(*light_, "normals", 0, targets_.normals.name());
    bindTexture(*light_, "points", 1, targets_.points.name());
    bindTexture(*light_, "ways", 2, targets_.ways.name());
    bindTexture(*light_, "passed", 3, passed);
    light_->set("passedGiven", passed ? 1 : 0);
    bindImage(0, targets_.color, GL_READ_WRITE, GL_RGBA32F);
    runOver(*light_, targets_.width, targets_.height);
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
    const bool met = picture.depth[i] < kNowhere;
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
  VOLUTE_TRY(prepare(camera, scene.geometry));
  look(camera, scene, passes);
  for (const Lamp& lamp : scene.lamps) VOLUTE_TRY(light(camera, lamp, attenuate, passes));
  SurfacePicture picture;
  passes.run("read back", [&] { picture = readBack(background); });
  return picture;
}

}  // namespace volute
