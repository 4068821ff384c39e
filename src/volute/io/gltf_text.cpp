// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/gltf_text.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "volute/base/lower_case.hpp"
#include "volute/base/printable.hpp"
#include "volute/io/json_check.hpp"

namespace volute {
namespace {

/// That a member is not there under a name that is nearly its own, or has so many numbers, up to
/// `most`.
Status checkNumbers(const nlohmann::json& object, const std::string& name, std::size_t count,
                    double most, const std::string& where) {
  if (!object.is_object())
    return fail(ErrorCode::kInvalidData, "{}: expected an object", where);
  for (const auto& [key, value] : object.items()) {
    if (key != name && lowerCase(key).starts_with(lowerCase(name)))
      return fail(ErrorCode::kInvalidData, "{}: '{}' is unknown; expected {}", where,
                  printable(key.substr(0, 60)), name);
  }
  const auto found = object.find(name);
  if (found == object.end())
    return {};
  const bool numbers =
      found->is_array() && std::ranges::all_of(*found, [&](const nlohmann::json& one) {
        return one.is_number() && std::abs(one.get<double>()) <= most;
      });
  if (numbers && found->size() == count)
    return {};
  return fail(ErrorCode::kInvalidData, "{}/{}: expected {} numbers of up to {:g}", where, name,
              count, most);
}

Status checkNode(const nlohmann::json& node, const std::string& where) {
  constexpr double kFar = 1e12;  // [m]
  VOLUTE_TRY(checkNumbers(node, "matrix", 16, kFar, where));
  for (const auto& [name, count] : {std::pair{"translation", 3}, {"rotation", 4}, {"scale", 3}}) {
    VOLUTE_TRY(checkNumbers(node, name, static_cast<std::size_t>(count), kFar, where));
    if (node.contains("matrix") && node.contains(name))
      return fail(ErrorCode::kInvalidData, "{}: has both matrix and {}; expected one of them",
                  where, name);
  }
  const auto extensions = node.find("extensions");
  if (extensions != node.end() && extensions->is_object() &&
      extensions->contains("EXT_mesh_gpu_instancing"))
    return fail(ErrorCode::kUnsupported,
                "{}: EXT_mesh_gpu_instancing is not read; export a node for each of its instances",
                where);
  return {};
}

/// "2.0" and later ones that a reader of 2.0 may read.
Status checkVersion(const nlohmann::json& gltf, const std::string& file) {
  const auto asset = gltf.find("asset");
  if (asset == gltf.end() || !asset->is_object())
    return {};  // the parser says what is missing
  for (const char* name : {"version", "minVersion"}) {
    const auto version = asset->find(name);
    if (version == asset->end())
      continue;
    const std::string text = version->is_string() ? version->get<std::string>() : version->dump();
    if (!text.starts_with("2.") || (std::string_view(name) == "minVersion" && text != "2.0"))
      return fail(ErrorCode::kUnsupported, "{}: /asset/{} is {}; expected glTF 2.0", file, name,
                  text);
  }
  return {};
}

}  // namespace

Result<nlohmann::json> parseGltf(std::string_view text, const std::string& file) {
  VOLUTE_TRY(checkJson(text, file));
  nlohmann::json gltf = nlohmann::json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!gltf.is_object())
    return fail(ErrorCode::kInvalidData, "{}: not a whole glTF 2.0 file", file);
  VOLUTE_TRY(checkVersion(gltf, file));
  const auto listed = [&](const char* name) {
    const auto found = gltf.find(name);
    return found != gltf.end() && found->is_array() ? *found : nlohmann::json::array();
  };
  constexpr double kBright = 1e6;  // exporters write more than the 1 that the format allows
  std::size_t number = 0;
  for (const nlohmann::json& node : listed("nodes"))
    VOLUTE_TRY(checkNode(node, fmt::format("{}: /nodes/{}", file, number++)));
  number = 0;
  for (const nlohmann::json& material : listed("materials")) {
    const std::string where = fmt::format("{}: /materials/{}", file, number++);
    VOLUTE_TRY(checkNumbers(material, "emissiveFactor", 3, kBright, where));
    const auto plain = material.find("pbrMetallicRoughness");
    if (plain != material.end())
      VOLUTE_TRY(checkNumbers(*plain, "baseColorFactor", 4, 1, where + "/pbrMetallicRoughness"));
  }
  return gltf;
}

}  // namespace volute
