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
constexpr std::int64_t kStepsOfPart = 1 << 24;  // through cells, between which the caller may stop

/// In widths of the fog's map: for farther eyes its azimuths are too narrow a part of the table,
/// and floats are too coarse for ways from the eye.
constexpr double kFarthestWidths = 2;

constexpr double kOpaqueDepth = 20;  // what is behind is less than 1e-8 of the light

/// Heights without an end do not make it wider, nor nearer than where its profile changes.
bool isFar(const FogMedium& fog, const FogShader& shader, const Vec3& eye) {
  const Box3 map = fog.bounds();
  const double width = map.size().head<2>().norm();
  double low = INFINITY, high = -INFINITY;
  for (const auto& heights : shader.zoneHeights) {
    for (const double height : heights) {
      if (std::abs(height) < FogProfile::kFarthest)
        low = std::min(low, height), high = std::max(high, height);
    }
  }
  Vec3 nearest = eye.cwiseMax(map.min).cwiseMin(map.max);
  nearest.z() =
      low > high ? eye.z() : std::clamp(eye.z(), shader.corner.z() + low, shader.corner.z() + high);
  return !((eye - nearest).norm() <= kFarthestWidths * width);
}

/// Until where the fog is walked depends on its factor.
ShaderPart opaqueSetting() {
  return {"fog settings", "uniform float fogOpaque;\n#define FOG_OPAQUE fogOpaque\n"};
}

std::vector<ShaderPart> tableParts(const FogShader& shader) {
  return {{"fog_walk.glsl", shader.walk},
          {"fog_polar.glsl", shader.polar},
          {"fog_polar_table.glsl", glsl::kFogPolarTable}};
}

std::vector<ShaderPart> pictureParts(const FogShader& shader, bool polar) {
  std::vector<ShaderPart> parts{
      {"ray.glsl", glsl::kRay}, opaqueSetting(), {"fog_walk.glsl", shader.walk}};
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

Result<PolarLayout> FogPasses::tableFor(const FogMedium& fog, const FogShader& shader,
                                        const Vec3& eye, const PolarOptions& options,
                                        GlPrograms& programs, GlPasses& passes,
                                        Progress& progress) {
  VOLUTE_ASSIGN(const auto layout, PolarLayout::of(fog, eye, options));
  VOLUTE_TRY(fillTable(shader, layout, eye, programs, passes, progress));
  return layout;
}

void FogPasses::sweep() {
  if (!used_) {
    map_.reset();
    table_ = {};
    columns_ = rows_ = 0;
    filled_.clear();
  }
  used_ = false;
}

Status FogPasses::draw(const FogMedium& fog, double factor,
                       const std::optional<PolarOptions>& polar, GlQuantity quantity,
                       const std::function<Result<std::shared_ptr<const GlFogMap>>()>& map,
                       const Camera& camera, const GlRays& rays, GLuint picture, int rowsAtOnce,
                       GlPrograms& programs, GlPasses& passes, Progress& progress) {
  const FogShader shader = fogCells(fog);
  if (camera.isOrthographic() || isFar(fog, shader, camera.eye()))
    return fail(ErrorCode::kUnsupported, "fog is not walked from this camera's eye");
  if (fog.hasTop() || fog.options().detail.cellAngle > 0)
    return fail(ErrorCode::kUnsupported, "fog_walk.glsl does not know this fog");
  VOLUTE_ASSIGN(auto wanted, map());
  if (map_ != wanted)
    filled_.clear();
  map_ = std::move(wanted);
  used_ = true;
  std::optional<PolarLayout> layout;
  if (polar && !shader.polar.empty()) {
    auto filled = tableFor(fog, shader, camera.eye(), *polar, programs, passes, progress);
    if (!filled && filled.error().code != ErrorCode::kUnsupported)
      return tl::unexpected(filled.error());
    if (filled)
      layout = *filled;
  }
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
  return passes.run(pass, "fog",
                    [&] { return runInBands(*program, camera, rowsAtOnce, progress); });
}

}  // namespace volute
