// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/gl_lamps.hpp"

#include <algorithm>
#include <bit>
#include <tuple>

#include "volute/gl/gl_triangles.hpp"
#include "volute/gl/glsl_sources.hpp"
#include "volute/media/fog/lit_fog.hpp"

namespace volute {
namespace {

constexpr std::size_t kMaxFieldBytes = 256u << 20;
constexpr double kRoundsPerLamp = 11;
constexpr double kCutsPerLamp = 2;  ///< of a ray through many cones, measured

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

}  // namespace

/// A lamp's light on the device.
struct GlLamps::One {
  LightField::Bricks field;  ///< without its words
  std::size_t first = 0;     ///< of them
  bool bricks = false;
  Lamp lamp{};
  std::vector<ShadingBall> balls{};
  GlTexture maps{};         ///< of a sun through the fog
  SunShadow::Maps shape{};  ///< of them, without their texels

  bool mapped() const { return shape.columns > 0; }
};

struct GlLamps::All {
  std::vector<One> lamps;
  Scattering scattering{};
  GlBuffer fields;
  DiffuseLight::Cells again{};  ///< without its values
  GlBuffer againValues;

  bool hasBricks() const { return std::ranges::any_of(lamps, &One::bricks); }

  bool isAgain() const { return again.count[0] > 0; }

  [[nodiscard]] static Result<All> make(const LitMedium& lit) {
    All out;
    out.scattering = lit.options().scattering;
    std::vector<std::uint32_t> words;
    GLint64 most = 0;
    glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &most);
    const std::size_t each =
        std::min<std::size_t>(static_cast<std::size_t>(most), kMaxFieldBytes) /
        (sizeof(std::uint32_t) * std::max<std::size_t>(lit.fields().size(), 1));
    for (const LightField& field : lit.fields()) {
      One lamp{field.bricks(each), words.size(), false, field.lamp()};
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
    if (const auto& again = lit.options().again) {
      out.again = again->cells();
      std::vector<std::uint32_t> values;
      for (const float value : out.again.values)
        values.push_back(std::bit_cast<std::uint32_t>(value));
      out.againValues = makeBuffer(values);
      out.again.values = {};
    }
    return out;
  }
};

Result<GlLamps> GlLamps::make(const std::shared_ptr<const LitMedium>& lit,
                              const TriangleScene& surfaces, const std::string& name,
                              GlResources& resources) {
  GlLamps made;
  if (lit->options().again && lit->options().scattering.asymmetry != 0) {
    return fail(ErrorCode::kUnsupported, Hint::set("renderer", "cpu"),
                "{} that scatters light more than once, and not evenly", name);
  }
  if (lit->options().shadows) {
    if (surfaces.empty()) {
      return fail(ErrorCode::kUnsupported, Hint::set("renderer", "cpu"),
                  "{} in the shadows of surfaces that OpenGL does not know", name);
    }
    // Scenes share their triangles: the same ones are at the same place.
    const auto held = std::make_shared<const TriangleScene>(surfaces);
    VOLUTE_ASSIGN(made.shade_, resources.upload<GlTriangles>(
                                   std::shared_ptr<const void>(held, held->triangles().data()),
                                   name, [&] { return GlTriangles::make(held->triangles()); }));
  }
  VOLUTE_ASSIGN(made.all_, resources.upload<All>(lit, name, [&] { return All::make(*lit); }));
  return made;
}

std::string GlLamps::key() const {
  if (!any())
    return "";
  std::string text = fmt::format("{} {}", shade_ != nullptr, all_->isAgain());
  for (const One& lamp : all_->lamps)
    text += fmt::format(" {}{}{}", lamp.bricks, lamp.mapped(), lamp.balls.size());
  return text;
}

std::string GlLamps::functions() const {
  const bool shaded = shade_ != nullptr, again = any() && all_->isAgain();
  const std::size_t lamps = any() ? all_->lamps.size() : 0;
  std::string text;
  if (any() && all_->hasBricks())
    text = "layout(std430) readonly buffer M_Field { uint M_field[]; };\n";
  for (std::size_t i = 0; i < lamps; ++i) {
    const One& lamp = all_->lamps[i];
    text += forLamp(i, fmt::format("#define M_BRICKS@ {}\n#define M_BALLS@ {}\n",
                                   lamp.bricks ? 1 : 0, lamp.balls.size()));
    text +=
        forLamp(i, lamp.mapped() ? glsl::kFogSun : "float M_known@(vec3 place) { return 1.0; }\n");
  }
  text += forLamps(lamps, glsl::kLightField);
  if (shaded) {
    text +=
        "layout(std430) readonly buffer M_ShadeNodes { vec4 M_shadeNodes[]; };\n"
        "layout(std430) readonly buffer M_ShadeCorners { dvec4 M_shadeCorners[]; };\n"
        "uniform dvec3 M_shadeOrigin;\n" +
        forLamps(lamps, glsl::kFogShade);
  }
  if (again)
    text += glsl::kLightAgain;
  const auto calls = [&](std::string_view line) { return shaded ? forLamps(lamps, line) : ""; };
  text += "vec3 M_sunlight(vec3 place, float s) {\n  vec3 sum = vec3(0.0);\n";
  text += forLamps(
      lamps, shaded ? "  if (!M_isDark@(s)) sum += M_sun@(place);\n" : "  sum += M_sun@(place);\n");
  text += again ? "  sum += M_again(place);\n" : "";
  // Nothing shades where only depths are asked for.
  text += "  return sum;\n}\nvoid M_findShadows() {\n#if !MEASURE\n";
  text += forLamps(lamps, "  M_findCone@();\n") + calls("  M_findDark@();\n");
  text += "#endif\n}\nfloat M_nextShadow(float s, float before) {\n#if !MEASURE\n";
  text += forLamps(lamps, "  before = M_evenTo@(s, before);\n") +
          calls("  before = M_nextEdge@(s, before);\n");
  return text + "#endif\n  return before;\n}\n";
}

GlNeeds GlLamps::needs() const {
  if (!any())
    return {};
  const auto mapped = std::ranges::count_if(all_->lamps, &One::mapped);
  return {.textures = static_cast<int>(mapped),
          .storage = (shade_ ? 2 : 0) + (all_->hasBricks() ? 1 : 0) + (all_->isAgain() ? 1 : 0),
          .cells = kCutsPerLamp * static_cast<double>(all_->lamps.size()),
          .roundsPerCell = kRoundsPerLamp * static_cast<double>(all_->lamps.size())};
}

void GlLamps::bind(const GlProgram& program, const std::string& prefix, const Vec3& origin,
                   GlBindings& bindings) const {
  if (!any())
    return;
  if (shade_) {
    program.bindStorage((prefix + "ShadeNodes").c_str(), bindings.storage++, shade_->nodes);
    program.bindStorage((prefix + "ShadeCorners").c_str(), bindings.storage++, shade_->corners);
    program.setExactly((prefix + "shadeOrigin").c_str(), Vec3(origin - shade_->middle));
  }
  if (all_->hasBricks())
    program.bindStorage((prefix + "Field").c_str(), bindings.storage++, all_->fields);
  if (all_->isAgain()) {
    program.bindStorage((prefix + "Again").c_str(), bindings.storage++, all_->againValues);
    program.set((prefix + "againLow").c_str(), Vec3(all_->again.low - origin));
    program.set((prefix + "againPerMetre").c_str(), all_->again.perMetre);
    program.set((prefix + "againCells").c_str(), all_->again.count);
    program.set((prefix + "againAlbedo").c_str(), Vec3(all_->scattering.albedo));
  }
  for (std::size_t i = 0; i < all_->lamps.size(); ++i) {
    const One& held = all_->lamps[i];
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
    set("lampShape", std::array{static_cast<float>(lamp.coneCosine), static_cast<float>(lamp.edge),
                                static_cast<float>(lamp.radius),
                                static_cast<float>(all_->scattering.asymmetry)});
    set("lampLight", Vec3(all_->scattering.albedo * lamp.intensity));
  }
}

}  // namespace volute
