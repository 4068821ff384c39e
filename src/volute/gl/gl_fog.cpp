// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/gl_fog.hpp"

#include <regex>

#include "volute/gl/fog_passes.hpp"
#include "volute/gl/gl_triangles.hpp"
#include "volute/gl/glsl_sources.hpp"

namespace volute {
namespace {

/// A sun over fog, on the device.
struct SunOnDevice {
  GlTexture maps;
  SunShadow::Maps shape;  ///< without its texels
  Vec3 way = Vec3::UnitZ();
  Rgb light = Rgb::Zero();  ///< albedo times irradiance
  double asymmetry = 0;
};

using SunsOnDevice = std::vector<SunOnDevice>;

Result<SunsOnDevice> sunsOf(const SunlitFog& fog) {
  SunsOnDevice suns;
  for (std::size_t i = 0; i < fog.suns().size(); ++i) {
    SunOnDevice sun;
    sun.shape = fog.shadows()[i].maps();
    VOLUTE_TRY(checkTextureSize("a sun's map of a fog", sun.shape.columns, sun.shape.rows));
    sun.maps = makeTexture2d(GL_RGBA32F, sun.shape.columns, sun.shape.rows);
    glTextureSubImage2D(sun.maps.name(), 0, 0, 0, sun.shape.columns, sun.shape.rows, GL_RGBA,
                        GL_FLOAT, sun.shape.texels.data());
    sun.shape.texels = {};
    sun.way = fog.shadows()[i].towardsSun();
    sun.light = fog.scattering().albedo * fog.suns()[i].irradiance;
    sun.asymmetry = fog.scattering().asymmetry;
    suns.push_back(std::move(sun));
  }
  return suns;
}

/// A line for each sun, with its number for @.
std::string forSuns(std::size_t suns, std::string_view line) {
  std::string text;
  for (std::size_t i = 0; i < suns; ++i) {
    for (const char c : line) text += c == '@' ? std::to_string(i) : std::string(1, c);
  }
  return text;
}

/// The functions of each sun, and their sum; nothing shades where only depths are asked for.
std::string sunFunctions(std::size_t suns, bool shaded) {
  std::string text = forSuns(suns, glsl::kFogSun);
  if (shaded) {
    text +=
        "layout(std430) readonly buffer M_ShadeNodes { vec4 M_shadeNodes[]; };\n"
        "layout(std430) readonly buffer M_ShadeCorners { dvec4 M_shadeCorners[]; };\n"
        "uniform dvec3 M_shadeOrigin;\n" +
        forSuns(suns, glsl::kFogShade);
  }
  const auto calls = [&](std::string_view line) { return shaded ? forSuns(suns, line) : ""; };
  text += "vec3 M_sunlight(vec3 place, float s) {\n  vec3 sum = vec3(0.0);\n";
  text += forSuns(
      suns, shaded ? "  if (!M_isDark@(s)) sum += M_sun@(place);\n" : "  sum += M_sun@(place);\n");
  text += "  return sum;\n}\nvoid M_findShadows() {\n#if !MEASURE\n" + calls("  M_findDark@();\n");
  text += "#endif\n}\nfloat M_nextShadow(float s, float before) {\n#if !MEASURE\n";
  text += calls("  before = M_nextEdge@(s, before);\n");
  return text + "#endif\n  return before;\n}\n";
}

/// fog_walk.glsl is given away too, where names begin with fog and FOG_ alone; the others call it.
std::string withOwnNames(const std::string& text) {
  return std::regex_replace(text, std::regex("\\b(FOG_|fog(?=[A-Z]))"), "M_$1");
}

constexpr double kFogRoundsPerCell = 11.1, kRoundsPerSun = 11;

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
              std::shared_ptr<const SunsOnDevice> suns = std::make_shared<SunsOnDevice>(),
              std::shared_ptr<const GlTriangles> shade = nullptr)
      : shader_(fogCells(fog)),
        bounds_(fog.bounds()),
        factor_(factor),
        color_(fog.options().color),
        cellAngle_(fog.options().detail.cellAngle),
        suns_(std::move(suns)),
        shade_(std::move(shade)),
        map_(std::move(map)) {
    if (const auto top = fog.top())
      top_.emplace(*top);
  }

  std::string key() const override {
    return fmt::format("fog {} {} {} {} {}", suns_->size(), shade_ != nullptr, cellAngle_ > 0,
                       top_.has_value(), shader_.structure);
  }

  std::vector<ShaderPart> parts() const override {
    return {{"fog settings", fmt::format("#define M_BY_ANGLE {}\n#define M_TOP {}\n",
                                         cellAngle_ > 0 ? 1 : 0, top_ ? 1 : 0)},
            {"fog_walk.glsl", withOwnNames(shader_.walk)},
            {"fog_sun.glsl", withOwnNames(sunFunctions(suns_->size(), shade_ != nullptr))},
            {"fog_cells.glsl", withOwnNames(glsl::kFogCells)}};
  }

  GlMediumTraits traits() const override {
    GlMediumTraits traits{.points = 4};
    if (suns_->empty())
      traits.color = color_;
    return traits;
  }

  GlNeeds needs() const override {
    const GlNeeds walk = fogNeeds(shader_);
    return {.textures = 1 + (top_ ? 1 : 0) + static_cast<int>(suns_->size()),
            .storage = shade_ ? 2 : 0,
            .cells = walk.cells,
            .roundsPerCell = walk.roundsPerCell +
                             kRoundsPerSun * double(suns_->size()) * double(shader_.zones.size())};
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
    if (shade_) {
      program.bindStorage((prefix + "ShadeNodes").c_str(), bindings.storage++, shade_->nodes);
      program.bindStorage((prefix + "ShadeCorners").c_str(), bindings.storage++, shade_->corners);
      program.setExactly((prefix + "shadeOrigin").c_str(), Vec3(origin - shade_->middle));
    }
    for (std::size_t i = 0; i < suns_->size(); ++i) {
      const SunOnDevice& sun = (*suns_)[i];
      const auto set = [&](const char* name, const auto& value) {
        program.set(fmt::format("{}sun{}{}", prefix, name, i).c_str(), value);
      };
      set("Maps", bindings.texture);
      glBindTextureUnit(static_cast<GLuint>(bindings.texture++), sun.maps.name());
      set("Way", sun.way);
      set("Corner", Vec3(sun.shape.x0 - origin.x(), sun.shape.y0 - origin.y(), sun.shape.step));
      set("Decay", static_cast<float>(sun.shape.decay));
      set("Light", Vec3(sun.light));
      set("Asymmetry", static_cast<float>(sun.asymmetry));
    }
  }

 private:
  FogShader shader_;
  Box3 bounds_;
  double factor_ = 1;
  Rgb color_;
  double cellAngle_ = 0;
  std::shared_ptr<const SunsOnDevice> suns_;
  std::shared_ptr<const GlTriangles> shade_;
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

class SunlitFogPart final : public GlPart {
 public:
  SunlitFogPart(std::shared_ptr<const SunlitFog> fog, double factor)
      : fog_(std::move(fog)), factor_(factor) {}

  std::string name() const override { return "fog"; }

  /// kUnsupported where it is shadowed by others than the picture's `shade`.
  Result<std::unique_ptr<GlMedium>> medium(const GlPicture& picture) const override {
    GlResources& resources = picture.resources;
    std::shared_ptr<const GlTriangles> shade;
    if (fog_->scattering().shadows) {
      if (picture.shade.empty()) {
        return fail(ErrorCode::kUnsupported, Hint::set("renderer", "cpu"),
                    "fog in the shadows of surfaces that OpenGL does not know");
      }
      // Scenes share their triangles: the same ones are at the same place.
      const auto held = std::make_shared<const TriangleScene>(picture.shade);
      VOLUTE_ASSIGN(shade, resources.upload<GlTriangles>(
                               std::shared_ptr<const void>(held, held->triangles().data()), name(),
                               [&] { return GlTriangles::make(held->triangles()); }));
    }
    VOLUTE_ASSIGN(auto map, fogMapOf(fog_->fog(), resources));
    VOLUTE_ASSIGN(auto suns,
                  resources.upload<SunsOnDevice>(fog_, name(), [&] { return sunsOf(*fog_); }));
    return std::make_unique<FogOnDevice>(fog_->fog(), factor_, std::move(map), std::move(suns),
                                         std::move(shade));
  }

  std::shared_ptr<const GlPart> scaled(double factor) const override {
    return std::make_shared<SunlitFogPart>(fog_, factor * factor_);
  }

 private:
  std::shared_ptr<const SunlitFog> fog_;
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

std::shared_ptr<const GlPart> glPart(GlSunlitFog fog) {
  return std::make_shared<SunlitFogPart>(std::make_shared<const SunlitFog>(std::move(fog.fog)),
                                         fog.factor);
}

}  // namespace volute
