// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/fog/fog_export.hpp"

#include <bit>
#include <nlohmann/json.hpp>
#include <system_error>

#include "volute/base/write_file.hpp"
#include "volute/fog/fog_shader.hpp"
#include "volute/fog/polar_table.hpp"
#include "volute/report/json_text.hpp"

namespace volute {
namespace {

constexpr const char* kLicense =
    "// SPDX-License-Identifier: Apache-2.0\n// SPDX-FileCopyrightText: The Volute authors\n";

constexpr const char* kReadme = R"(# Fog for your shaders

Written by `volute fog --export-glsl`; Apache-2.0, like Volute itself.

* `fog.glsl`: put it behind your shader's first lines, `#version 450` or
  `#version 300 es` with `precision highp float; precision highp int;`. It offers
  `float fogOpticalDepth(vec3 eye, vec3 direction, float distance)`: metres, a unit
  vector, 1e30 for no end. A fogged pixel, in linear light, is
  `mix(fogColor, color, exp(-fogOpticalDepth(eye, direction, distance)))`.
* `fog_map.f32`: the texture `fogMap`, float32, little-endian, {width} x {height}, first row first,
  as `glTexImage2D(GL_TEXTURE_2D, 0, GL_R32F, {width}, {height}, 0, GL_RED, GL_FLOAT, bytes)` takes it.
  Extinctions in 1/m, all levels of the map below one another (`fogLevels` in fog.glsl has
  their cells and first rows). GL_NEAREST, no mipmaps.
* `fog.json`: the values of the uniforms. Wind moves `fogCorner`; `fogMu` may change at will.
{polar}
Degree, levels, size of the map and height profile are constants in fog.glsl: export again to
change them. Transmittances are within 2e-5 of the exact ones for eyes within a few map sizes.
)";

constexpr const char* kPolarReadme =
    R"(* `fog_polar.glsl`, behind fog.glsl: a table for one eye, two look-ups instead of a walk. Draw
  `fogPolarEntry(eye, ivec2(gl_FragCoord.xy), size)` into an RGBA32F texture of radii x
  azimuths when the eye moves, then call `fogPolarOpticalDepth`. Uniforms: fogPolar,
  fogPolarYaw, fogPolarTangent, fogPolarSectors, fogPolarRadii, fogPolarBends (in fog.json); its
  head explains them. In OpenGL ES 3.0 drawing to RGBA32F needs EXT_color_buffer_float.
)";

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += by.size())
    text.replace(at, what.size(), by);
  return text;
}

nlohmann::ordered_json uniforms(const FogShader& shader, const Rgb& color) {
  return {{"format", "volute-fog-shader-1"},
          {"fogMap",
           {{"file", "fog_map.f32"},
            {"internal_format", "R32F"},
            {"width", shader.width},
            {"height", shader.height}}},
          {"fogCorner", {shader.corner.x(), shader.corner.y(), shader.corner.z()}},
          {"fogCell", shader.cell},
          {"fogMu", shader.mu},
          {"fogColor", {color[0], color[1], color[2]}}};
}

}  // namespace

Status exportFogShader(const FogMedium& fog, const std::filesystem::path& folder) {
  static_assert(std::endian::native == std::endian::little);
  VOLUTE_ASSIGN(const auto shader, fogShader(fog));
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!std::filesystem::is_directory(folder, error))
    return fail(ErrorCode::kIo, "cannot make the folder '{}'", folder.string());
  VOLUTE_TRY(writeFile(folder / "fog.glsl", kLicense + shader.walk));
  if (!shader.polar.empty())
    VOLUTE_TRY(writeFile(folder / "fog_polar.glsl", shader.polar));
  VOLUTE_TRY(writeFile(folder / "fog_map.f32", std::as_bytes(std::span(shader.texels))));
  auto values = uniforms(shader, fog.options().color);
  if (!shader.polar.empty())
    values["fogPolarBends"] = largestBends(fog.levels().map());
  VOLUTE_TRY(writeFile(folder / "fog.json", dumpJson(values)));
  std::string readme = replaced(kReadme, "{width}", fmt::format("{}", shader.width));
  readme = replaced(readme, "{height}", fmt::format("{}", shader.height));
  return writeFile(folder / "README.md",
                   replaced(readme, "{polar}", shader.polar.empty() ? "" : kPolarReadme));
}

}  // namespace volute
