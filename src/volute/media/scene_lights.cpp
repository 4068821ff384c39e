// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/scene_lights.hpp"

#include <cmath>
#include <numbers>

#include "volute/io/json_members.hpp"

namespace volute {
namespace {

using Json = nlohmann::json;

Result<Lamp> parseSpot(const Json& json, const std::string& file, const std::string& path) {
  constexpr std::string_view kNames[] = {"kind",      "position", "target", "angle",
                                         "intensity", "radius",   "edge"};
  const Members members(json, file, path);
  VOLUTE_TRY(members.check(kNames));
  for (const char* key : {"position", "target"}) {
    if (!members.has(key))
      return fail(ErrorCode::kInvalidData, "{}: {}: is missing; expected three numbers [m]", file,
                  members.where(key));
  }
  Lamp lamp;
  Vec3 target = Vec3::Zero();
  double angle = 60;
  VOLUTE_TRY(members.vector("position", lamp.position));
  VOLUTE_TRY(members.vector("target", target));
  VOLUTE_TRY(members.number("angle", angle, 0, 360));
  VOLUTE_TRY(members.color("intensity", lamp.intensity, kUnlimited));
  VOLUTE_TRY(members.number("radius", lamp.radius, 1e-6));
  lamp.edge = 0.1;
  VOLUTE_TRY(members.number("edge", lamp.edge, 0, 1));
  if (!((target - lamp.position).norm() > 0)) {
    return fail(ErrorCode::kInvalidData, "{}: {}: position and target are the same point", file,
                path);
  }
  lamp.direction = (target - lamp.position).normalized();
  lamp.coneCosine = std::cos(angle / 2 * std::numbers::pi / 180);
  return lamp;
}

Result<FogSun> parseSun(const Json& json, const std::string& file, const std::string& path) {
  constexpr std::string_view kNames[] = {"kind", "direction", "radiance"};
  const Members members(json, file, path);
  VOLUTE_TRY(members.check(kNames));
  if (json.value("kind", Json()) != "sun")
    return fail(ErrorCode::kInvalidData, "{}: {}/kind: expected sun, spot or ambient", file, path);
  FogSun sun;
  Vec3 direction = Vec3::Zero();
  VOLUTE_TRY(members.vector("direction", direction));
  if (!(direction.z() < 0)) {
    return fail(ErrorCode::kInvalidData,
                "{}: {}/direction: expected three numbers, the way the light travels, with a "
                "third below 0",
                file, path);
  }
  sun.towards = -direction;
  VOLUTE_TRY(members.color("radiance", sun.irradiance, kUnlimited));
  return sun;
}

Lamp lampOf(const FogSun& sun) {
  Lamp lamp;
  lamp.kind = Lamp::Kind::kSun;
  lamp.direction = -sun.towards.normalized();
  lamp.intensity = sun.irradiance;
  return lamp;
}

Status parseAmbient(const Json& json, const std::string& file, const std::string& path,
                    Rgb& ambient) {
  constexpr std::string_view kNames[] = {"kind", "radiance"};
  const Members members(json, file, path);
  VOLUTE_TRY(members.check(kNames));
  Rgb radiance = Rgb::Zero();
  VOLUTE_TRY(members.color("radiance", radiance, kUnlimited));
  ambient += radiance;
  return {};
}

}  // namespace

Result<SceneLights> parseLights(const Json& json, const std::string& file,
                                const std::string& path) {
  if (!json.is_array())
    return fail(ErrorCode::kInvalidData, "{}: {}: expected a list", file, path);
  SceneLights lights;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const std::string at = fmt::format("{}/{}", path, i);
    const Json kind = json[i].is_object() ? json[i].value("kind", Json()) : Json();
    if (kind == "spot") {
      VOLUTE_ASSIGN(const Lamp lamp, parseSpot(json[i], file, at));
      lights.lamps.push_back(lamp);
    } else if (kind == "ambient") {
      VOLUTE_TRY(parseAmbient(json[i], file, at, lights.ambient));
    } else {
      VOLUTE_ASSIGN(const FogSun sun, parseSun(json[i], file, at));
      lights.suns.push_back(sun);
      lights.lamps.push_back(lampOf(sun));
    }
  }
  return lights;
}

}  // namespace volute
