// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/polar_pass.hpp"

#include <cmath>

#include "volute/gl/glsl_sources.hpp"

namespace volute {
namespace {

constexpr int kMapUnit = 3, kTableUnit = 4;  // after those of the rays

Result<GlProgram> linked(std::vector<ShaderPart> parts) {
  const ShaderStage stage{GL_COMPUTE_SHADER, std::move(parts)};
  return GlProgram::link({&stage, 1});
}

}  // namespace

Result<const PolarPass::Programs*> PolarPass::programsFor(const FogShader& shader) {
  const auto found = programs_.find(shader.walk);
  if (found != programs_.end())
    return &found->second;
  const ShaderPart walk{"fog_walk.glsl", shader.walk}, polar{"fog_polar.glsl", shader.polar};
  VOLUTE_ASSIGN(auto table, linked({walk, polar, {"fog_polar_table.glsl", glsl::kFogPolarTable}}));
  VOLUTE_ASSIGN(auto picture, linked({{"ray.glsl", glsl::kRay},
                                      walk,
                                      polar,
                                      {"fog_polar_picture.glsl", glsl::kFogPolarPicture}}));
  Programs programs{std::move(table), std::move(picture)};
  return &programs_.emplace(shader.walk, std::move(programs)).first->second;
}

void PolarPass::bindFog(const GlProgram& program, const FogShader& shader,
                        const PolarLayout& layout, const Vec3& eye) const {
  program.set("fogCorner", Vec3(shader.corner - eye));
  program.set("fogCell", static_cast<float>(shader.cell));
  program.set("fogMu", static_cast<float>(shader.mu));
  program.set("fogMap", kMapUnit);
  program.set("fogPolar", kTableUnit);
  program.set("fogPolarYaw", std::array{static_cast<float>(std::cos(layout.yaw)),
                                        static_cast<float>(std::sin(layout.yaw))});
  program.set("fogPolarTangent", static_cast<float>(layout.tangent));
  program.set("fogPolarSectors", layout.sectors);
  program.set("fogPolarRadii",
              std::array{static_cast<float>(layout.from), static_cast<float>(layout.step)});
  glBindTextureUnit(kMapUnit, map_.name());
}

Status PolarPass::draw(const FogMedium& fog, double factor, const PolarOptions& options,
                       const Camera& camera, const GlRays& rays, GLuint picture, GlPasses& passes) {
  VOLUTE_ASSIGN(const auto layout, PolarLayout::of(fog, camera.eye(), options));
  VOLUTE_ASSIGN(auto shader, fogShader(fog));
  if (shader.polar.empty() || camera.isOrthographic())
    return fail(ErrorCode::kUnsupported, "no polar table serves this fog from this camera");
  VOLUTE_ASSIGN(const Programs* programs, programsFor(shader));
  for (float& texel : shader.texels) texel = static_cast<float>(factor * texel);
  const int columns = layout.radii, rows = layout.sectors * layout.azimuths;
  const Vec3 from = shader.corner - camera.eye();
  const std::string wanted =
      fmt::format("{} {} {} {} {} {} {} {} {}", from.x(), from.y(), layout.yaw, layout.tangent,
                  layout.sectors, layout.from, layout.step, columns, rows) +
      shader.walk;
  if (!map_ || wanted != filled_ || mapTexels_ != shader.texels) {
    passes.run("polar table", "fog", [&] {
      map_ = makeTexture2d(GL_R32F, shader.width, shader.height);
      glTextureSubImage2D(map_.name(), 0, 0, 0, shader.width, shader.height, GL_RED, GL_FLOAT,
                          shader.texels.data());
      if (columns_ != columns || rows_ != rows)
        table_ = makeTexture2d(GL_RGBA32F, columns, rows);
      columns_ = columns, rows_ = rows;
      bindFog(programs->table, shader, layout, camera.eye());
      glBindTextureUnit(kTableUnit, 0);
      glBindImageTexture(0, table_.name(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
      runOver(programs->table, columns, rows);
    });
    filled_ = wanted;
    mapTexels_ = shader.texels;
  }
  passes.run("polar", "fog", [&] {
    bindRays(programs->picture, camera, rays);
    bindFog(programs->picture, shader, layout, camera.eye());
    programs->picture.set("color", Vec3(fog.options().color));
    glBindTextureUnit(kTableUnit, table_.name());
    glBindImageTexture(0, picture, 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
    runOver(programs->picture, camera.width(), camera.height());
  });
  return {};
}

}  // namespace volute
