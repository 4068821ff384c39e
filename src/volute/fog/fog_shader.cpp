// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fog/fog_shader.hpp"

#include <algorithm>

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

/// What the functions need to know of this fog.
std::string constants(const FogMedium& fog) {
  const GaussRule rule = ruleFor(fog);
  std::vector<std::string> levels, heights, zones, nodes, weights;
  const std::vector<int> rows = firstRows(fog);
  for (int i = 0; i < fog.levels().count(); ++i) {
    const FogLevels::Level& level = fog.levels().level(i);
    levels.push_back(fmt::format("ivec4({}, {}, {}, 0)", level.cellsX, level.cellsY, rows[i]));
  }
  for (const FogProfile::Zone& zone : fog.profile().zones()) {
    heights.push_back(fmt::format("vec2({}, {})", number(zone.bottom), number(zone.top)));
    zones.push_back(fmt::format("vec4({}, {}, {}, {})", number(zone.value), number(zone.slope),
                                number(zone.decay), number(zone.reference)));
  }
  if (zones.empty()) {  // a profile that is zero everywhere
    heights.push_back("vec2(0.0, 1.0)");
    zones.push_back("vec4(0.0)");
  }
  for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
    nodes.push_back(number(0.5 + 0.5 * rule.nodes[i]));
    weights.push_back(number(0.5 * rule.weights[i]));
  }
  const CellRect map = fog.levels().mapCells();
  return fmt::format(
             "#define FOG_DEGREE {}\n#define FOG_LEVELS {}\n#define FOG_ZONES {}\n"
             "#define FOG_POINTS {}\nconst ivec4 fogMapCells = ivec4({}, {}, {}, {});\n",
             fog.options().degree, levels.size(), zones.size(), nodes.size(), map.x0, map.y0,
             map.x1, map.y1) +
         array("ivec4", "fogLevels", "FOG_LEVELS", levels) +
         array("vec2", "fogZoneHeights", "FOG_ZONES", heights) +
         array("vec4", "fogZones", "FOG_ZONES", zones) +
         array("float", "fogNodes", "FOG_POINTS", nodes) +
         array("float", "fogNodeWeights", "FOG_POINTS", weights);
}

void fillTexels(const FogMedium& fog, FogShader& shader) {
  const int degree = fog.options().degree;
  const std::vector<int> rows = firstRows(fog);
  const int last = fog.levels().count() - 1;
  shader.width = fog.levels().level(0).cellsX + degree;
  shader.height = rows[last] + fog.levels().level(last).cellsY + degree;
  shader.texels.assign(static_cast<std::size_t>(shader.width) * shader.height, 0);
  for (int level = 0; level <= last; ++level) {
    const SplineGrid& grid = fog.levels().pyramid().level(level);
    for (int j = 0; j < grid.rows; ++j) {
      for (int i = 0; i < grid.columns; ++i) {
        const std::size_t row = static_cast<std::size_t>(rows[level]) + j + degree;
        shader.texels[row * shader.width + i + degree] = static_cast<float>(grid.at(i, j));
      }
    }
  }
}

}  // namespace

Result<FogShader> fogShader(const FogMedium& fog) {
  if (fog.hasTop() || fog.options().detail.cellAngle > 0) {
    return fail(ErrorCode::kUnsupported,
                "the shader serves fog without a top, and levels chosen by mu only");
  }
  FogShader shader = fogCells(fog);
  if (fog.options().detail.finestOnly() && !exponential(fog))
    shader.polar = detail::kFogPolarGlsl;
  return shader;
}

FogShader fogCells(const FogMedium& fog) {
  FogShader shader;
  shader.walk = constants(fog) + detail::kFogWalkGlsl;
  fillTexels(fog, shader);
  shader.corner = fog.domainCorner();
  shader.cell = fog.cell();
  shader.mu = fog.options().detail.mu;
  return shader;
}

}  // namespace volute
