// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/gl_fog.hpp"

#include <algorithm>
#include <regex>

#include "volute/gl/fog_passes.hpp"
#include "volute/gl/gl_lamps.hpp"
#include "volute/gl/glsl_sources.hpp"

namespace volute {
namespace {

/// fog_walk.glsl is given away too, where names begin with fog and FOG_ alone; the others call it.
std::string withOwnNames(const std::string& text) {
  return std::regex_replace(text, std::regex("\\b(FOG_|fog(?=[A-Z]))"), "M_$1");
}

constexpr double kFogRoundsPerCell = 11.1;

/// The fog's top on the device.
struct TopOnDevice {
  GlTexture map;
  Vec3 corner = Vec3::Zero();  ///< of the cell before the first node
  double cell = 1;

  explicit TopOnDevice(const FogMap& top)
      : map(makeTexture2d(GL_R32F, top.coefficients.columns, top.coefficients.rows)),
        corner(top.origin),
        cell(top.cell) {
    const std::vector<float> heights(top.coefficients.c.begin(), top.coefficients.c.end());
    glTextureSubImage2D(map.name(), 0, 0, 0, top.coefficients.columns, top.coefficients.rows,
                        GL_RED, GL_FLOAT, heights.data());
  }
};

class FogOnDevice final : public GlMedium {
 public:
  FogOnDevice(const FogMedium& fog, double factor, std::shared_ptr<const GlFogMap> map,
              GlLamps lamps = {})
      : shader_(fogCells(fog)),
        bounds_(fog.bounds()),
        factor_(factor),
        color_(fog.options().color),
        cellAngle_(fog.options().detail.cellAngle),
        lamps_(std::move(lamps)),
        map_(std::move(map)) {
    if (const auto top = fog.top())
      top_.emplace(*top);
  }

  std::string key() const override {
    return fmt::format("fog {} {} {} {}", lamps_.key(), cellAngle_ > 0, top_.has_value(),
                       shader_.structure);
  }

  std::vector<ShaderPart> parts() const override {
    return {{"fog settings", fmt::format("#define M_BY_ANGLE {}\n#define M_TOP {}\n",
                                         cellAngle_ > 0 ? 1 : 0, top_ ? 1 : 0)},
            {"fog_walk.glsl", withOwnNames(shader_.walk)},
            {"light_field.glsl", withOwnNames(lamps_.functions())},
            {"fog_cells.glsl", withOwnNames(glsl::kFogCells)}};
  }

  GlMediumTraits traits() const override {
    GlMediumTraits traits{.points = 4};
    if (!lamps_.any())
      traits.color = color_;
    return traits;
  }

  GlNeeds needs() const override {
    const GlNeeds walk = fogNeeds(shader_);
    const GlNeeds lamps = lamps_.needs();
    return {.textures = 1 + (top_ ? 1 : 0) + lamps.textures,
            .storage = lamps.storage,
            .cells = walk.cells + lamps.cells,
            .roundsPerCell = walk.roundsPerCell + lamps.roundsPerCell};
  }

  Box3 bounds() const override { return bounds_; }

  void bind(const GlProgram& program, const std::string& prefix, const GlView& view,
            GlBindings& bindings) const override {
    const Vec3& origin = view.origin;
    bindFog(program, prefix, shader_, origin, bindings.texture++, *map_);
    program.set((prefix + "fogFactor").c_str(), static_cast<float>(factor_));
    program.set((prefix + "fogColor").c_str(), Vec3(color_));
    if (cellAngle_ > 0) {
      program.set((prefix + "levelMetres").c_str(),
                  static_cast<float>(2 * shader_.cell / cellAngle_));
    }
    if (top_) {
      program.set((prefix + "topCorner").c_str(),
                  std::array{static_cast<float>(top_->corner.x() - origin.x()),
                             static_cast<float>(top_->corner.y() - origin.y())});
      program.set((prefix + "topCell").c_str(), static_cast<float>(top_->cell));
      program.set((prefix + "topMap").c_str(), bindings.texture);
      glBindTextureUnit(static_cast<GLuint>(bindings.texture++), top_->map.name());
    }
    lamps_.bind(program, prefix, origin, bindings);
  }

 private:
  FogShader shader_;
  Box3 bounds_;
  double factor_ = 1;
  Rgb color_;
  double cellAngle_ = 0;
  GlLamps lamps_;
  std::optional<TopOnDevice> top_;
  std::shared_ptr<const GlFogMap> map_;
};

class FogPart final : public GlPart {
 public:
  explicit FogPart(GlFog fog) : fog_(std::move(fog)) {}

  std::string name() const override { return "fog"; }

  Result<std::unique_ptr<GlMedium>> medium(const GlPicture& picture) const override {
    VOLUTE_ASSIGN(auto map, fogMapOf(fog_.fog, picture.resources));
    return std::make_unique<FogOnDevice>(fog_.fog, fog_.factor, std::move(map));
  }

  Status drawAlone(const GlPicture& picture, const GlTarget& target) const override {
    return drawFogAlone(fog_, picture, target);
  }

  std::shared_ptr<const GlPart> scaled(double factor) const override {
    GlFog fog = fog_;
    fog.factor *= factor;
    return glPart(std::move(fog));
  }

 private:
  GlFog fog_;
};

class LitFogPart final : public GlPart {
 public:
  LitFogPart(FogMedium fog, std::shared_ptr<const LitMedium> lit, double factor)
      : fog_(std::move(fog)), lit_(std::move(lit)), factor_(factor) {}

  std::string name() const override { return "fog"; }

  Result<std::unique_ptr<GlMedium>> medium(const GlPicture& picture) const override {
    VOLUTE_ASSIGN(auto map, fogMapOf(fog_, picture.resources));
    VOLUTE_ASSIGN(auto lamps, GlLamps::make(lit_, picture.shade, name(), picture.resources));
    return std::make_unique<FogOnDevice>(fog_, factor_, std::move(map), std::move(lamps));
  }

  std::shared_ptr<const GlPart> scaled(double factor) const override {
    return std::make_shared<LitFogPart>(fog_, lit_, factor * factor_);
  }

 private:
  FogMedium fog_;
  std::shared_ptr<const LitMedium> lit_;
  double factor_;
};

}  // namespace

GlNeeds fogNeeds(const FogShader& shader) {
  const int cells = shader.levels[0][0] + shader.levels[0][1];  // coarser ones are fewer
  return {.textures = 1, .cells = static_cast<double>(cells), .roundsPerCell = kFogRoundsPerCell};
}

void bindFog(const GlProgram& program, const std::string& prefix, const FogShader& shader,
             const Vec3& origin, int unit, const GlFogMap& map) {
  const auto set = [&](const char* name, const auto& value) {
    program.set((prefix + name).c_str(), value);
  };
  set("fogCorner", Vec3(shader.corner - origin));
  set("fogCell", static_cast<float>(shader.cell));
  set("fogMu", static_cast<float>(shader.mu));
  set("fogMapCells", shader.mapCells);
  set("fogLevels", std::span(shader.levels));
  set("fogZoneHeights", std::span(shader.zoneHeights));
  set("fogZones", std::span(shader.zones));
  set("fogMap", unit);
  glBindTextureUnit(static_cast<GLuint>(unit), map.texture.name());
}

std::shared_ptr<const GlPart> glPart(GlFog fog) {
  return std::make_shared<FogPart>(std::move(fog));
}

std::shared_ptr<const GlPart> glPart(GlLitFog fog) {
  return std::make_shared<LitFogPart>(
      std::move(fog.fog), std::make_shared<const LitMedium>(std::move(fog.lit)), fog.factor);
}

}  // namespace volute
