// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fog/fog_shader.hpp"

#include <algorithm>
#include <type_traits>

#include "volute/math/quadrature.hpp"

namespace volute {

namespace detail {
extern const char* const kFogWalkGlsl;
extern const char* const kFogPolarGlsl;
}  // namespace detail

namespace {

std::string number(double value) {
  return fmt::format("{:.9e}", value);
}

/// The elements of a constant array.
std::string array(const char* type, const char* name, const char* size,
                  const std::vector<std::string>& elements) {
  std::string text = fmt::format("const {} {}[{}] = {}[{}](", type, name, size, type, size);
  for (std::size_t i = 0; i < elements.size(); ++i) text += (i ? ", " : "") + elements[i];
  return text + ");\n";
}

bool exponential(const FogMedium& fog) {
  return std::ranges::any_of(fog.profile().zones(), [](const auto& z) { return z.decay != 0; });
}

/// Enough for the spline along a ray, of degree 2d, times a line; two more are 3e-7 within an
/// exponential over one scale height.
GaussRule ruleFor(const FogMedium& fog) {
  const int wanted = fog.options().degree + (exponential(fog) ? 3 : 1);
  return gaussRule(wanted <= 2 ? 2 : wanted <= 5 ? wanted : 8);
}

/// Rows of each level's part in the texture.
std::vector<int> firstRows(const FogMedium& fog) {
  std::vector<int> rows;
  int next = 0;
  for (int i = 0; i < fog.levels().count(); ++i) {
    rows.push_back(next);
    next += fog.levels().level(i).cellsY + fog.options().degree;
  }
  return rows;
}

void fillValues(const FogMedium& fog, FogShader& shader) {
  const std::vector<int> rows = firstRows(fog);
  for (int i = 0; i < fog.levels().count(); ++i) {
    const FogLevels::Level& level = fog.levels().level(i);
    shader.levels.push_back({level.cellsX, level.cellsY, rows[i], 0});
  }
  for (const FogProfile::Zone& zone : fog.profile().zones()) {
    shader.zoneHeights.push_back({static_cast<float>(zone.bottom), static_cast<float>(zone.top)});
    shader.zones.push_back({static_cast<float>(zone.value), static_cast<float>(zone.slope),
                            static_cast<float>(zone.decay), static_cast<float>(zone.reference)});
  }
  if (shader.zones.empty()) {  // a profile that is zero everywhere
    shader.zoneHeights.push_back({0, 1});
    shader.zones.push_back({});
  }
  const CellRect map = fog.levels().mapCells();
  shader.mapCells = {map.x0, map.y0, map.x1, map.y1};
  shader.corner = fog.domainCorner();
  shader.cell = fog.cell();
  shader.mu = fog.options().detail.mu;
  const FogLevels::Level& finest = fog.levels().level(0);
  const int last = fog.levels().count() - 1, degree = fog.options().degree;
  shader.width = finest.cellsX + degree;
  shader.height = rows[last] + fog.levels().level(last).cellsY + degree;
}

std::string structureOf(const FogMedium& fog, const FogShader& shader) {
  return fmt::format(
      "#define FOG_DEGREE {}\n#define FOG_LEVELS {}\n#define FOG_ZONES {}\n#define FOG_POINTS {}\n"
      "#define FOG_EXPONENTIAL {}\n",
      fog.options().degree, shader.levels.size(), shader.zones.size(), ruleFor(fog).nodes.size(),
      exponential(fog) ? 1 : 0);
}

std::string ruleText(const FogMedium& fog) {
  const GaussRule rule = ruleFor(fog);
  std::vector<std::string> nodes, weights;
  for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
    nodes.push_back(number(0.5 + 0.5 * rule.nodes[i]));
    weights.push_back(number(0.5 * rule.weights[i]));
  }
  return array("float", "fogNodes", "FOG_POINTS", nodes) +
         array("float", "fogNodeWeights", "FOG_POINTS", weights);
}

/// "vec4(1, 2, 3, 4)" for each.
template <class T, std::size_t kCount>
std::vector<std::string> vectors(const char* type,
                                 const std::vector<std::array<T, kCount>>& values) {
  std::vector<std::string> texts;
  for (const auto& value : values) {
    std::string text = type + std::string("(");
    for (std::size_t i = 0; i < kCount; ++i) {
      text += i ? ", " : "";
      if constexpr (std::is_integral_v<T>)
        text += std::to_string(value[i]);
      else
        text += number(value[i]);
    }
    texts.push_back(text + ")");
  }
  return texts;
}

std::string constantValues(const FogShader& shader) {
  const auto& cells = shader.mapCells;
  return fmt::format("const ivec4 fogMapCells = ivec4({}, {}, {}, {});\n", cells[0], cells[1],
                     cells[2], cells[3]) +
         array("ivec4", "fogLevels", "FOG_LEVELS", vectors("ivec4", shader.levels)) +
         array("vec2", "fogZoneHeights", "FOG_ZONES", vectors("vec2", shader.zoneHeights)) +
         array("vec4", "fogZones", "FOG_ZONES", vectors("vec4", shader.zones));
}

constexpr const char* kUniformValues =
    "uniform ivec4 fogMapCells;\nuniform ivec4 fogLevels[FOG_LEVELS];\n"
    "uniform vec2 fogZoneHeights[FOG_ZONES];\nuniform vec4 fogZones[FOG_ZONES];\n";

}  // namespace

std::vector<float> fogTexels(const FogMedium& fog) {
  const int degree = fog.options().degree;
  const std::vector<int> rows = firstRows(fog);
  const int last = fog.levels().count() - 1;
  const std::size_t width = fog.levels().level(0).cellsX + degree;
  const std::size_t height = rows[last] + fog.levels().level(last).cellsY + degree;
  std::vector<float> texels(width * height);
  for (int level = 0; level <= last; ++level) {
    const SplineGrid& grid = fog.levels().pyramid().level(level);
    for (int j = 0; j < grid.rows; ++j) {
      for (int i = 0; i < grid.columns; ++i) {
        const std::size_t row = static_cast<std::size_t>(rows[level]) + j + degree;
        texels[row * width + i + degree] = static_cast<float>(grid.at(i, j));
      }
    }
  }
  return texels;
}

Result<FogShader> fogShader(const FogMedium& fog) {
  if (fog.hasTop() || fog.options().detail.cellAngle > 0) {
    return fail(ErrorCode::kUnsupported,
                "the shader serves fog without a top, and levels chosen by mu only");
  }
  FogShader shader = fogCells(fog);
  shader.walk = shader.structure + constantValues(shader) + ruleText(fog) + detail::kFogWalkGlsl;
  shader.texels = fogTexels(fog);
  return shader;
}

FogShader fogCells(const FogMedium& fog) {
  FogShader shader;
  fillValues(fog, shader);
  shader.structure = structureOf(fog, shader);
  shader.walk = shader.structure + kUniformValues + ruleText(fog) + detail::kFogWalkGlsl;
  if (!fog.hasTop() && fog.options().detail.finestOnly() && !exponential(fog))
    shader.polar = detail::kFogPolarGlsl;
  return shader;
}

}  // namespace volute
