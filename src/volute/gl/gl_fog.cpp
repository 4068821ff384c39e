// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/gl_fog.hpp"

#include <algorithm>
#include <regex>
#include <tuple>

#include "volute/gl/fog_passes.hpp"
#include "volute/gl/gl_triangles.hpp"
#include "volute/gl/glsl_sources.hpp"
#include "volute/media/fog/lit_fog.hpp"

namespace volute {
namespace {

/// A lamp's light in fog, on the device.
struct LampOnDevice {
  LightField::Bricks field;  ///< without its words
  std::size_t first = 0;     ///< of them
  bool bricks = false;
  Lamp lamp{};
  std::vector<ShadingBall> balls{};
  GlTexture maps{};         ///< of a sun through the fog
  SunShadow::Maps shape{};  ///< of them, without their texels

  bool mapped() const { return shape.columns > 0; }
};

constexpr std::size_t kMaxFieldBytes = 256u << 20;

struct LampsOnDevice {
  std::vector<LampOnDevice> lamps;
  Scattering scattering{};
  GlBuffer fields;
};

Result<LampsOnDevice> lampsOf(const LitMedium& fog) {
  LampsOnDevice out;
  out.scattering = fog.options().scattering;
  std::vector<std::uint32_t> words;
  GLint64 most = 0;
  glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &most);
  const std::size_t each = std::min<std::size_t>(static_cast<std::size_t>(most), kMaxFieldBytes) /
                           (sizeof(std::uint32_t) * std::max<std::size_t>(fog.fields().size(), 1));
  for (const LightField& field : fog.fields()) {
    LampOnDevice lamp{field.bricks(each), words.size(), false, field.lamp()};
    lamp.bricks = !lamp.field.words.empty();
    words.insert(words.end(), lamp.field.words.begin(), lamp.field.words.end());
    lamp.field.words = {};
    lamp.balls.assign(field.balls().begin(), field.balls().end());
    if (const auto* sun = dynamic_cast<const SunInFog*>(field.known())) {
      lamp.shape = sun->maps.maps();
      VOLUTE_TRY(checkTextureSize("a sun's map of a fog", lamp.shape.columns, lamp.shape.rows));
      lamp.maps = makeTexture2d(GL_RGBA32F, lamp.shape.columns, lamp.shape.rows);
      glTextureSubImage2D(lamp.maps.name(), 0, 0, 0, lamp.shape.columns, lamp.shape.rows, GL_RGBA,
                          GL_FLOAT, lamp.shape.texels.data());
      lamp.shape.texels = {};
    }
    out.lamps.push_back(std::move(lamp));
  }
  out.fields = makeBuffer(words);
  return out;
}

/// A line, with a lamp's number for @.
std::string forLamp(std::size_t lamp, std::string_view line) {
  std::string text;
  for (const char c : line) text += c == '@' ? std::to_string(lamp) : std::string(1, c);
  return text;
}

/// A line for each lamp.
std::string forLamps(std::size_t lamps, std::string_view line) {
  std::string text;
  for (std::size_t i = 0; i < lamps; ++i) text += forLamp(i, line);
  return text;
}

/// Of each lamp what its functions are made of.
std::string lampKinds(const std::vector<LampOnDevice>& lamps) {
  std::string text;
  for (const LampOnDevice& lamp : lamps)
    text += fmt::format(" {}{}{}", lamp.bricks, lamp.mapped(), lamp.balls.size());
  return text;
}

/// The functions of each lamp, and their sum; nothing shades where only depths are asked for.
std::string lampFunctions(const std::vector<LampOnDevice>& all, bool shaded) {
  const std::size_t lamps = all.size();
  std::string text;
  if (std::ranges::any_of(all, &LampOnDevice::bricks))
    text = "layout(std430) readonly buffer M_Field { uint M_field[]; };\n";
  for (std::size_t i = 0; i < lamps; ++i) {
    text += forLamp(i, fmt::format("#define M_BRICKS@ {}\n#define M_BALLS@ {}\n",
                                   all[i].bricks ? 1 : 0, all[i].balls.size()));
    text += forLamp(
        i, all[i].mapped() ? glsl::kFogSun : "float M_known@(vec3 place) { return 1.0; }\n");
  }
  text += forLamps(lamps, glsl::kLightField);
  if (shaded) {
    text +=
        "layout(std430) readonly buffer M_ShadeNodes { vec4 M_shadeNodes[]; };\n"
        "layout(std430) readonly buffer M_ShadeCorners { dvec4 M_shadeCorners[]; };\n"
        "uniform dvec3 M_shadeOrigin;\n" +
        forLamps(lamps, glsl::kFogShade);
  }
  const auto calls = [&](std::string_view line) { return shaded ? forLamps(lamps, line) : ""; };
  text += "vec3 M_sunlight(vec3 place, float s) {\n  vec3 sum = vec3(0.0);\n";
  text += forLamps(
      lamps, shaded ? "  if (!M_isDark@(s)) sum += M_sun@(place);\n" : "  sum += M_sun@(place);\n");
  text += "  return sum;\n}\nvoid M_findShadows() {\n#if !MEASURE\n" + calls("  M_findDark@();\n");
  text += "#endif\n}\nfloat M_nextShadow(float s, float before) {\n#if !MEASURE\n";
  text += forLamps(lamps, "  before = M_evenTo@(s, before);\n") +
          calls("  before = M_nextEdge@(s, before);\n");
  return text + "#endif\n  return before;\n}\n";
}

/// fog_walk.glsl is given away too, where names begin with fog and FOG_ alone; the others call it.
std::string withOwnNames(const std::string& text) {
  return std::regex_replace(text, std::regex("\\b(FOG_|fog(?=[A-Z]))"), "M_$1");
}

constexpr double kFogRoundsPerCell = 11.1, kRoundsPerLamp = 11;

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
              std::shared_ptr<const LampsOnDevice> lamps = std::make_shared<LampsOnDevice>(),
              std::shared_ptr<const GlTriangles> shade = nullptr)
      : shader_(fogCells(fog)),
        bounds_(fog.bounds()),
        factor_(factor),
        color_(fog.options().color),
        cellAngle_(fog.options().detail.cellAngle),
        lamps_(std::move(lamps)),
        shade_(std::move(shade)),
        map_(std::move(map)) {
    if (const auto top = fog.top())
      top_.emplace(*top);
  }

  std::string key() const override {
    return fmt::format("fog {} {} {} {} {}", lampKinds(lamps_->lamps), shade_ != nullptr,
                       cellAngle_ > 0, top_.has_value(), shader_.structure);
  }

  std::vector<ShaderPart> parts() const override {
    return {{"fog settings", fmt::format("#define M_BY_ANGLE {}\n#define M_TOP {}\n",
                                         cellAngle_ > 0 ? 1 : 0, top_ ? 1 : 0)},
            {"fog_walk.glsl", withOwnNames(shader_.walk)},
            {"light_field.glsl", withOwnNames(lampFunctions(lamps_->lamps, shade_ != nullptr))},
            {"fog_cells.glsl", withOwnNames(glsl::kFogCells)}};
  }

  GlMediumTraits traits() const override {
    GlMediumTraits traits{.points = 4};
    if (lamps_->lamps.empty())
      traits.color = color_;
    return traits;
  }

  GlNeeds needs() const override {
    const GlNeeds walk = fogNeeds(shader_);
    const auto mapped = std::ranges::count_if(lamps_->lamps, &LampOnDevice::mapped);
    return {.textures = 1 + (top_ ? 1 : 0) + static_cast<int>(mapped),
            .storage = (shade_ ? 2 : 0) + (hasBricks() ? 1 : 0),
            .cells = walk.cells,
            .roundsPerCell = walk.roundsPerCell + kRoundsPerLamp * double(lamps_->lamps.size())};
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
    if (hasBricks())
      program.bindStorage((prefix + "Field").c_str(), bindings.storage++, lamps_->fields);
    for (std::size_t i = 0; i < lamps_->lamps.size(); ++i) {
      const LampOnDevice& held = lamps_->lamps[i];
      const auto& [field, lamp, shape] = std::tie(held.field, held.lamp, held.shape);
      const bool sun = lamp.kind == Lamp::Kind::kSun;
      const auto set = [&](const char* name, const auto& value) {
        program.set(fmt::format("{}{}{}", prefix, name, i).c_str(), value);
      };
      if (held.bricks) {
        set("fieldFirst", static_cast<int>(held.first));
        set("fieldAxes", field.axes);
        set("fieldOffset", Vec3(field.axes * origin + field.offset));
        set("fieldRoots", field.roots);
        set("fieldReach",
            std::array{static_cast<float>(field.nearest), static_cast<float>(field.scale)});
      }
      for (std::size_t k = 0; held.bricks && k < held.balls.size(); ++k) {
        const Vec3 centre = held.balls[k].centre - origin;
        program.set(
            fmt::format("{}balls{}[{}]", prefix, i, k).c_str(),
            std::array{static_cast<float>(centre.x()), static_cast<float>(centre.y()),
                       static_cast<float>(centre.z()), static_cast<float>(held.balls[k].radius)});
      }
      if (held.mapped()) {
        set("sunMaps", bindings.texture);
        glBindTextureUnit(static_cast<GLuint>(bindings.texture++), held.maps.name());
        set("sunWay", Vec3(-lamp.direction));
        set("sunCorner", Vec3(shape.x0 - origin.x(), shape.y0 - origin.y(), shape.step));
        set("sunDecay", static_cast<float>(shape.decay));
      }
      set("lampIsSun", sun ? 1 : 0);
      set("lampPlace", Vec3(sun ? Vec3(-lamp.direction) : Vec3(lamp.position - origin)));
      set("lampWay", lamp.direction);
      set("lampShape", std::array{static_cast<float>(lamp.coneCosine),
                                  static_cast<float>(lamp.edge), static_cast<float>(lamp.radius),
                                  static_cast<float>(lamps_->scattering.asymmetry)});
      set("lampLight", Vec3(lamps_->scattering.albedo * lamp.intensity));
    }
  }

 private:
  bool hasBricks() const { return std::ranges::any_of(lamps_->lamps, &LampOnDevice::bricks); }

  FogShader shader_;
  Box3 bounds_;
  double factor_ = 1;
  Rgb color_;
  double cellAngle_ = 0;
  std::shared_ptr<const LampsOnDevice> lamps_;
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

class LitFogPart final : public GlPart {
 public:
  LitFogPart(FogMedium fog, std::shared_ptr<const LitMedium> lit, double factor)
      : fog_(std::move(fog)), lit_(std::move(lit)), factor_(factor) {}

  std::string name() const override { return "fog"; }

  /// kUnsupported where it is shadowed by others than the picture's `shade`.
  Result<std::unique_ptr<GlMedium>> medium(const GlPicture& picture) const override {
    if (lit_->options().again) {
      return fail(ErrorCode::kUnsupported, Hint::set("renderer", "cpu"),
                  "fog that scatters light more than once");
    }
    GlResources& resources = picture.resources;
    std::shared_ptr<const GlTriangles> shade;
    if (lit_->options().shadows) {
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
    VOLUTE_ASSIGN(auto map, fogMapOf(fog_, resources));
    VOLUTE_ASSIGN(auto lamps,
                  resources.upload<LampsOnDevice>(lit_, name(), [&] { return lampsOf(*lit_); }));
    return std::make_unique<FogOnDevice>(fog_, factor_, std::move(map), std::move(lamps),
                                         std::move(shade));
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
