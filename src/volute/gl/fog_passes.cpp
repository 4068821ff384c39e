// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/fog_passes.hpp"

#include <algorithm>
#include <cmath>

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

/// A polar table on the device.
struct FogTable {
  GlTexture texture;
  int columns = 0, rows = 0;
  std::string filled;             ///< what it was filled for, besides the map
  std::array<double, 2> bends{};  ///< largestBends()
};

/// FogMedium does not give its levels away, but a copy holds them.
std::shared_ptr<const void> levelsOf(const FogMedium& fog) {
  const auto held = std::make_shared<const FogMedium>(fog);
  return {held, &held->levels()};
}

void bindTable(const GlProgram& program, const PolarLayout& layout, const FogTable& table) {
  program.set("fogPolar", kTableUnit);
  program.set("fogPolarYaw", std::array{static_cast<float>(std::cos(layout.yaw)),
                                        static_cast<float>(std::sin(layout.yaw))});
  program.set("fogPolarTangent", static_cast<float>(layout.tangent));
  program.set("fogPolarSectors", layout.sectors);
  program.set("fogPolarRadii",
              std::array{static_cast<float>(layout.from), static_cast<float>(layout.step)});
  program.set("fogPolarBends",
              std::array{static_cast<float>(table.bends[0]), static_cast<float>(table.bends[1])});
}

Status fillTable(FogTable& table, const FogMedium& fog, const FogShader& shader,
                 const PolarLayout& layout, const GlFogMap& map, const GlPicture& picture) {
  GlResources& resources = picture.resources;
  const int columns = layout.radii, rows = layout.sectors * layout.azimuths;
  const Vec3 eye = picture.camera.eye();
  const Vec3 from = shader.corner - eye;
  const std::string wanted =
      fmt::format("{} {} {} {} {} {} {} {} {} {}", from.x(), from.y(), shader.cell, layout.yaw,
                  layout.tangent, layout.sectors, layout.from, layout.step, columns, rows);
  if (wanted == table.filled)
    return {};
  if (!checkTextureSize("", columns, rows))
    return fail(ErrorCode::kUnsupported, "the polar table is larger than the device's textures");
  VOLUTE_ASSIGN(const GlProgram* program,
                resources.programs.get("polar table\n" + shader.structure, "fog", resources.passes,
                                       [&] { return tableParts(shader); }));
  table.filled.clear();
  if (table.columns == 0)  // a table is of one map
    table.bends = largestBends(fog.levels().map());
  if (table.columns != columns || table.rows != rows)
    table.texture = makeTexture2d(GL_RGBA32F, columns, rows);
  table.columns = columns, table.rows = rows;
  bindFog(*program, "", shader, eye, kMapUnit, map);
  bindTable(*program, layout, table);
  glBindTextureUnit(kTableUnit, 0);
  glBindImageTexture(0, table.texture.name(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  const std::int64_t texels = kStepsOfPart / columns;  // each a walk through at most all radii
  const auto width = static_cast<int>(std::clamp<std::int64_t>(texels / kGroup, kGroup, columns));
  const auto height = static_cast<int>(std::clamp<std::int64_t>(texels / width, kGroup, rows));
  const auto fill = [&]() -> Status {
    for (int row = 0; row < rows; row += height) {
      for (int column = 0; column < columns; column += width) {
        if (picture.progress.cancelled()) {
          return fail(ErrorCode::kCancelled, "stopped: {} of {} azimuths were looked along", row,
                      rows);
        }
        program->set("first", std::array{column, row});
        runOver(*program, width, height);
        glFlush();
      }
      picture.progress.report("looking along azimuths", std::min(row + height, rows), rows);
    }
    return {};
  };
  VOLUTE_TRY(resources.passes.run("polar table", "fog", fill));
  table.filled = wanted;
  return {};
}

/// kUnsupported where no table serves.
Result<PolarLayout> layoutFor(const GlFog& fog, const FogShader& shader, const Camera& camera) {
  const auto options = fog.polar ? fog.polar(camera) : std::nullopt;
  if (!options || shader.polar.empty())
    return fail(ErrorCode::kUnsupported, "this fog has no polar table");
  return PolarLayout::of(fog.fog, camera.eye(), *options);
}

}  // namespace

Result<std::shared_ptr<GlFogMap>> fogMapOf(const FogMedium& fog, GlResources& resources) {
  return resources.upload<GlFogMap>(levelsOf(fog), "fog", [&]() -> Result<GlFogMap> {
    const FogShader shader = fogCells(fog);
    VOLUTE_TRY(checkTextureSize("a fog map", shader.width, shader.height));
    const std::vector<float> texels = fogTexels(fog);
    GlFogMap map{makeTexture2d(GL_R32F, shader.width, shader.height)};
    glTextureSubImage2D(map.texture.name(), 0, 0, 0, shader.width, shader.height, GL_RED, GL_FLOAT,
                        texels.data());
    return map;
  });
}

Status drawFogAlone(const GlFog& fog, const GlPicture& picture, const GlTarget& target) {
  const Camera& camera = picture.camera;
  GlResources& resources = picture.resources;
  const FogShader shader = fogCells(fog.fog);
  const GlNeeds needs = fogNeeds(shader);
  if (needs.cells * needs.roundsPerCell > resources.device.loopRounds())
    return fail(ErrorCode::kUnsupported, "the software rasteriser does not walk as far");
  if (camera.isOrthographic() || isFar(fog.fog, shader, camera.eye()))
    return fail(ErrorCode::kUnsupported, "fog is not walked from this camera's eye");
  if (fog.fog.hasTop() || fog.fog.options().detail.cellAngle > 0)
    return fail(ErrorCode::kUnsupported, "fog_walk.glsl does not know this fog");
  VOLUTE_ASSIGN(const auto map, fogMapOf(fog.fog, resources));
  std::shared_ptr<FogTable> table;
  auto layout = layoutFor(fog, shader, camera);
  if (layout) {
    VOLUTE_ASSIGN(
        table, resources.store.get<FogTable>(levelsOf(fog.fog), [] { return Result<FogTable>(); }));
    if (const Status filled = fillTable(*table, fog.fog, shader, *layout, *map, picture); !filled)
      layout = tl::unexpected(filled.error());
  }
  if (!layout && layout.error().code != ErrorCode::kUnsupported)
    return tl::unexpected(layout.error());
  const char* const pass = layout ? "polar" : "walk";
  VOLUTE_ASSIGN(const GlProgram* program,
                resources.programs.get(fmt::format("{} picture\n{}", pass, shader.structure), "fog",
                                       resources.passes,
                                       [&] { return pictureParts(shader, layout.has_value()); }));
  bindRays(*program, camera, camera.eye(), target.rays);
  bindFog(*program, "", shader, camera.eye(), kMapUnit, *map);
  if (layout) {
    bindTable(*program, *layout, *table);
    glBindTextureUnit(kTableUnit, table->texture.name());
  }
  program->set("color", Vec3(fog.fog.options().color));
  program->set("factor", static_cast<float>(fog.factor));
  program->set("fogOpaque", static_cast<float>(target.quantity == GlQuantity::kLight
                                                   ? kOpaqueDepth / std::max(fog.factor, 1e-30)
                                                   : 1e30));
  glBindImageTexture(0, target.picture, 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  return resources.passes.run(pass, "fog", [&] {
    return runInBands(*program, camera, resources.device.rowsAtOnce(camera.width()),
                      picture.progress);
  });
}

}  // namespace volute
