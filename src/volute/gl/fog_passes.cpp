// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/fog_passes.hpp"

#include <algorithm>
#include <cmath>

#include "volute/gl/gl_device.hpp"
#include "volute/gl/glsl_sources.hpp"

namespace volute {
namespace {

constexpr int kMapUnit = 3, kTableUnit = 4;  // after those of the rays
constexpr int kGroup = 8;
// Between parts of so much work, and of so many rows, the caller may stop.
constexpr std::int64_t kStepsOfPart = 1 << 24;  // through cells

/// In sizes of the fog: for farther eyes its azimuths are too narrow a part of the table, and
/// floats are too coarse for ways from the eye.
constexpr double kFarthest = 2;

constexpr double kOpaqueDepth = 20;  // what is behind is less than 1e-8 of the light

bool isFar(const Box3& fog, const Vec3& eye) {
  const Vec3 nearest = eye.cwiseMax(fog.min).cwiseMin(fog.max);
  return (eye - nearest).norm() > kFarthest * fog.size().norm();
}

/// What a walk through fog may end at is known where `factor` is.
const ShaderPart kOpaque{"fog settings",
                         "uniform float fogOpaque;\n#define FOG_OPAQUE fogOpaque\n"};

std::vector<ShaderPart> tableParts(const FogShader& shader) {
  return {{"fog_walk.glsl", shader.walk},
          {"fog_polar.glsl", shader.polar},
          {"fog_polar_table.glsl", glsl::kFogPolarTable}};
}

std::vector<ShaderPart> pictureParts(const FogShader& shader, bool polar) {
  std::vector<ShaderPart> parts{{"ray.glsl", glsl::kRay}, kOpaque, {"fog_walk.glsl", shader.walk}};
  if (polar)
    parts.push_back({"fog_polar.glsl", shader.polar});
  parts.push_back({"fog settings", fmt::format("#define FOG_BY_TABLE {}\n", polar ? 1 : 0)});
  parts.push_back({"fog_picture.glsl", glsl::kFogPicture});
  return parts;
}

}  // namespace

void FogPasses::bindTable(const GlProgram& program, const PolarLayout& layout) const {
  program.set("fogPolar", kTableUnit);
  program.set("fogPolarYaw", std::array{static_cast<float>(std::cos(layout.yaw)),
                                        static_cast<float>(std::sin(layout.yaw))});
  program.set("fogPolarTangent", static_cast<float>(layout.tangent));
  program.set("fogPolarSectors", layout.sectors);
  program.set("fogPolarRadii",
              std::array{static_cast<float>(layout.from), static_cast<float>(layout.step)});
}

Status FogPasses::fillTable(const FogShader& shader, const PolarLayout& layout, const Vec3& eye,
                            GlPrograms& programs, GlPasses& passes, Progress& progress) {
  const int columns = layout.radii, rows = layout.sectors * layout.azimuths;
  const Vec3 from = shader.corner - eye;
  const std::string wanted =
      fmt::format("{} {} {} {} {} {} {} {} {} {}", from.x(), from.y(), shader.cell, layout.yaw,
                  layout.tangent, layout.sectors, layout.from, layout.step, columns, rows);
  if (wanted == filled_)
    return {};
  if (!checkTextureSize("", columns, rows))
    return fail(ErrorCode::kUnsupported, "the polar table is larger than the device's textures");
  VOLUTE_ASSIGN(const GlProgram* program, programs.get("polar table\n" + shader.structure, "fog",
                                                       passes, [&] { return tableParts(shader); }));
  filled_.clear();
  if (columns_ != columns || rows_ != rows)
    table_ = makeTexture2d(GL_RGBA32F, columns, rows);
  columns_ = columns, rows_ = rows;
  bindFog(*program, "", shader, eye, kMapUnit, *map_);
  bindTable(*program, layout);
  glBindTextureUnit(kTableUnit, 0);
  glBindImageTexture(0, table_.name(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  const std::int64_t texels = kStepsOfPart / columns;  // each a walk through at most all radii
  const auto width = static_cast<int>(std::clamp<std::int64_t>(texels / kGroup, kGroup, columns));
  const auto height = static_cast<int>(std::clamp<std::int64_t>(texels / width, kGroup, rows));
  const auto fill = [&]() -> Status {
    for (int row = 0; row < rows; row += height) {
      for (int column = 0; column < columns; column += width) {
        if (progress.cancelled()) {
          return fail(ErrorCode::kCancelled, "stopped: {} of {} azimuths were looked along", row,
                      rows);
        }
        program->set("first", std::array{column, row});
        runOver(*program, width, height);
        glFlush();
      }
      progress.report("looking along azimuths", std::min(row + height, rows), rows);
    }
    return {};
  };
  VOLUTE_TRY(passes.run("polar table", "fog", fill));
  filled_ = wanted;
  return {};
}

Status FogPasses::draw(const FogMedium& fog, double factor,
                       const std::optional<PolarOptions>& polar, GlQuantity quantity,
                       const std::function<Result<std::shared_ptr<const GlFogMap>>()>& map,
                       const Camera& camera, const GlRays& rays, GLuint picture, int rowsAtOnce,
                       GlPrograms& programs, GlPasses& passes, Progress& progress) {
  const FogShader shader = fogCells(fog);
  if (camera.isOrthographic() || isFar(fog.bounds(), camera.eye()))
    return fail(ErrorCode::kUnsupported, "this fog is not walked from this camera's eye");
  std::optional<PolarLayout> layout;
  if (polar && !shader.polar.empty()) {
    VOLUTE_ASSIGN(layout, PolarLayout::of(fog, camera.eye(), *polar));
  }
  if (!layout && (fog.hasTop() || fog.options().detail.cellAngle > 0))
    return fail(ErrorCode::kUnsupported, "fog_walk.glsl does not know this fog");
  VOLUTE_ASSIGN(auto wanted, map());
  if (map_ != wanted)
    filled_.clear();
  map_ = std::move(wanted);
  if (layout)
    VOLUTE_TRY(fillTable(shader, *layout, camera.eye(), programs, passes, progress));
  const char* const pass = layout ? "polar" : "walk";
  VOLUTE_ASSIGN(const GlProgram* program,
                programs.get(fmt::format("{} picture\n{}", pass, shader.structure), "fog", passes,
                             [&] { return pictureParts(shader, layout.has_value()); }));
  bindRays(*program, camera, camera.eye(), rays);
  bindFog(*program, "", shader, camera.eye(), kMapUnit, *map_);
  if (layout) {
    bindTable(*program, *layout);
    glBindTextureUnit(kTableUnit, table_.name());
  }
  program->set("color", Vec3(fog.options().color));
  program->set("factor", static_cast<float>(factor));
  program->set("fogOpaque", static_cast<float>(quantity == GlQuantity::kLight
                                                   ? kOpaqueDepth / std::max(factor, 1e-30)
                                                   : 1e30));
  glBindImageTexture(0, picture, 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  return passes.run(pass, "fog", [&]() -> Status {
    for (int row = 0; row < camera.height(); row += rowsAtOnce) {
      if (progress.cancelled()) {
        return fail(ErrorCode::kCancelled, "stopped: {} of {} rows were rendered", row,
                    camera.height());
      }
      program->set("firstRow", row);
      runOver(*program, camera.width(), std::min(rowsAtOnce, camera.height() - row));
      glFlush();
    }
    return {};
  });
}

}  // namespace volute
