// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/scene_shader.hpp"

#include <algorithm>
#include <regex>

#include "volute/gl/glsl_sources.hpp"
#include "volute/math/quadrature.hpp"

namespace volute {
namespace {

enum class March { kConstant, kProportional, kThin, kGeneral };

const char* name(March march) {
  constexpr const char* kNames[] = {"MARCH_CONSTANT", "MARCH_PROPORTIONAL", "MARCH_THIN",
                                    "MARCH_GENERAL"};
  return kNames[static_cast<int>(march)];
}

struct Plan {
  March march = March::kGeneral;
  int points = 4;
};

/// Media of several kinds need all of Gauss' points at once; what is cubic alone needs two.
Plan planFor(std::span<const std::unique_ptr<GlMedium>> media) {
  Plan plan;
  bool constant = true, absorbs = false;
  int points = 1;
  for (const auto& medium : media) {
    const GlMediumTraits traits = medium->traits();
    constant = constant && traits.constant;
    absorbs = absorbs || traits.absorbs;
    points = std::max(points, traits.points);
  }
  if (constant)
    return {March::kConstant, 1};
  if (!absorbs)
    return {March::kThin, points};
  if (media.size() == 1 && media[0]->traits().color)
    return {March::kProportional, points};
  return plan;
}

std::string number(double value) {
  return fmt::format("{:.9e}", value);
}

std::string array(const char* name, const std::vector<double>& values) {
  std::string text = fmt::format("const float {}[{}] = float[](", name, values.size());
  for (std::size_t i = 0; i < values.size(); ++i) text += (i ? ", " : "") + number(values[i]);
  return text + ");\n";
}

/// Gauss' rule on 0..1, and the integrals of the polynomials through its points up to each of them.
std::string rule(int points) {
  const GaussRule gauss = gaussRule(points);
  std::vector<double> nodes, weights, before;
  for (int i = 0; i < points; ++i) {
    nodes.push_back(0.5 + 0.5 * gauss.nodes[i]);
    weights.push_back(0.5 * gauss.weights[i]);
  }
  for (int i = 0; i < points; ++i) {
    for (int j = 0; j < points; ++j) {
      before.push_back(gaussIntegral(points, 0, nodes[i], [&](double x) {
        double lagrange = 1;
        for (int k = 0; k < points; ++k) {
          if (k != j)
            lagrange *= (x - nodes[k]) / (nodes[j] - nodes[k]);
        }
        return lagrange;
      }));
    }
  }
  return array("gaussNodes", nodes) + array("gaussWeights", weights) + array("gaussBefore", before);
}

std::string settings(const Plan& plan, GlQuantity quantity) {
  std::string text;
  for (const March march : {March::kConstant, March::kProportional, March::kThin, March::kGeneral})
    text += fmt::format("#define {} {}\n", name(march), static_cast<int>(march));
  text += fmt::format("#define MARCH {}\n#define POINTS {}\n#define MEASURE {}\n", name(plan.march),
                      plan.points, quantity == GlQuantity::kOpticalDepth ? 1 : 0);
  return text + "uniform vec3 marchColor;\n" + rule(plan.points);
}

/// A line for each medium, with @ for its prefix.
std::string forEach(std::size_t media, const std::string& line) {
  std::string text;
  for (std::size_t i = 0; i < media; ++i) {
    for (const char c : line) text += c == '@' ? mediumPrefix(i) : std::string(1, c);
    text += '\n';
  }
  return text;
}

std::string mediaAt(std::size_t media) {
  return "void mediaAt(float s, inout float k, inout vec3 e) {\n" +
         forEach(media, "  @sample(s, k, e);") + "}\n";
}

/// From where one medium changes to where the next does.
std::string mainFunction(std::size_t media) {
  return R"(void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy) + ivec2(0, firstRow);
  if (!castRay(pixel)) {
    if (all(lessThan(pixel, size))) imageStore(picture, pixel, vec4(0.0));
    return;
  }
)" + forEach(media, "  @begin();") +
         R"(  float s = rayFrom;
  bool whole = false;  // else the device ended a loop before its time
  for (int step = 0; step < 1000000; ++step) {
    float to = FARTHEST;
    bool any = false;
)" + forEach(media, "    to = min(to, @end); any = any || @on;") +
         R"(    whole = to >= FARTHEST;
    if (whole) break;
    if (any && to > s) march(s, to);
#if !MEASURE
    whole = depth > DARK;
    if (whole) break;
#endif
    s = max(s, to);
)" + forEach(media, "    while (@end <= s) @next();") +
         R"(  }
  imageStore(picture, pixel, vec4(light, whole ? depth : uintBitsToFloat(0x7fc00000u)));
}
)";
}

}  // namespace

std::string withPrefix(const std::string& text, const std::string& prefix) {
  return std::regex_replace(text, std::regex("\\bM_"), prefix);
}

std::string mediumPrefix(std::size_t index) {
  return fmt::format("m{}_", index);
}

std::string sceneShaderKey(std::span<const std::unique_ptr<GlMedium>> media, GlQuantity quantity) {
  const Plan plan = planFor(media);
  std::string key =
      fmt::format("{} {} {}\n", name(plan.march), plan.points, static_cast<int>(quantity));
  for (const auto& medium : media) key += medium->key() + '\n';
  return key;
}

Rgb marchColor(std::span<const std::unique_ptr<GlMedium>> media) {
  const std::optional<Rgb> color = media.size() == 1 ? media[0]->traits().color : std::nullopt;
  return color.value_or(Rgb::Zero());
}

std::vector<ShaderPart> sceneShader(std::span<const std::unique_ptr<GlMedium>> media,
                                    GlQuantity quantity) {
  std::vector<ShaderPart> parts{{"scene settings", settings(planFor(media), quantity)},
                                {"ray.glsl", glsl::kRay}};
  for (std::size_t i = 0; i < media.size(); ++i) {
    for (const ShaderPart& part : media[i]->parts())
      parts.push_back({part.file, withPrefix(part.text, mediumPrefix(i))});
  }
  parts.push_back({"scene", mediaAt(media.size())});
  parts.push_back({"march.glsl", glsl::kMarch});
  parts.push_back({"scene", mainFunction(media.size())});
  return parts;
}

}  // namespace volute
