// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/scene_lights.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "volute/media/field_members.hpp"

namespace volute {
namespace {

/// A lamp as a scene says it.
struct SpotDescription {
  Vec3 position = Vec3::Zero(), target = Vec3::Zero();
  double angle = 60;  ///< of its cone, from side to side [degrees]
  Rgb intensity = Rgb::Ones();
  double radius = Lamp{}.radius;
  double edge = 0.1;
};

struct AmbientDescription {
  Rgb radiance = Rgb::Zero();
};

FieldValue sunDirection(const Sun& sun) {
  const Vec3 direction = -sun.towards + Vec3::Zero();
  return {direction.x(), direction.y(), direction.z()};
}

Status setSunDirection(Sun& sun, const FieldValue& value) {
  if (!(value[2].get<double>() < 0)) {
    return fail(ErrorCode::kInvalidData,
                "expected three numbers, the way the light travels, with a third below 0");
  }
  sun.towards = -Vec3(value[0].get<double>(), value[1].get<double>(), value[2].get<double>());
  return {};
}

Lamp lampOf(const SpotDescription& spot) {
  Lamp lamp;
  lamp.position = spot.position;
  lamp.direction = (spot.target - spot.position).normalized();
  lamp.coneCosine = std::cos(spot.angle / 2 * std::numbers::pi / 180);
  lamp.edge = spot.edge;
  lamp.intensity = spot.intensity;
  lamp.radius = spot.radius;
  return lamp;
}

const FieldTable& spotFields() {
  using enum FieldType;
  // clang-format off: a row is read as one
  static const FieldRow kFields[] = {
      {.name = "position", .type = kPoint, .access = member<&SpotDescription::position>(),
       .help = "position of the lamp", .unit = "m", .required = true,
       .slider = {.label = "position"}},
      {.name = "target", .type = kPoint, .access = member<&SpotDescription::target>(),
       .help = "the point it shines at", .unit = "m", .required = true,
       .slider = {.label = "target"}},
      {.name = "angle", .access = member<&SpotDescription::angle>(),
       .help = "full angle of the cone", .unit = "degrees", .least = 0, .most = 360,
       .above = true, .slider = {.label = "cone", .least = 1, .most = 179}},
      {.name = "intensity", .type = kColor, .access = member<&SpotDescription::intensity>(),
       .help = "power per solid angle", .least = 0, .slider = {.label = "intensity"}},
      {.name = "radius", .access = member<&SpotDescription::radius>(),
       .help = "distance below which the light gets no stronger", .unit = "m", .least = 1e-6},
      {.name = "edge", .access = member<&SpotDescription::edge>(),
       .help = "share of the half angle over which the light falls off at the rim", .least = 0,
       .most = 1}};
  // clang-format on
  static const FieldTable kTable = fieldTable<SpotDescription>(
      {.name = "spot", .sentence = "a lamp", .fields = kFields, .kind = "spot"});
  return kTable;
}

const FieldTable& ambientFields() {
  // clang-format off: a row is read as one
  static const FieldRow kFields[] = {
      {.name = "radiance", .type = FieldType::kColor,
       .access = member<&AmbientDescription::radiance>(), .help = "radiance from all directions",
       .least = 0,
       .slider = {.label = "radiance"}}};
  // clang-format on
  static const FieldTable kTable =
      fieldTable<AmbientDescription>({.name = "ambient",
                                      .sentence = "light from all directions, without shadows",
                                      .fields = kFields,
                                      .kind = "ambient"});
  return kTable;
}

Status addLight(const nlohmann::json& json, const FieldOrigin& origin, SceneLights& lights) {
  const nlohmann::json kind = json.is_object() ? json.value("kind", nlohmann::json()) : json;
  if (kind == "sun") {
    VOLUTE_ASSIGN(const auto sun, readAs<Sun>(sunFields(), json, origin));
    lights.suns.push_back(sun);
    lights.lamps.push_back(lampOf(sun));
  } else if (kind == "ambient") {
    VOLUTE_ASSIGN(const auto ambient, readAs<AmbientDescription>(ambientFields(), json, origin));
    lights.ambient += ambient.radiance;
  } else if (kind == "spot") {
    VOLUTE_ASSIGN(const auto spot, readAs<SpotDescription>(spotFields(), json, origin));
    if (!((spot.target - spot.position).norm() > 0))
      return origin.wrong("position and target are the same point");
    lights.lamps.push_back(lampOf(spot));
  } else {
    return origin.wrong(FieldRow{.name = "kind"}, "expected sun, spot or ambient");
  }
  return {};
}

}  // namespace

Lamp lampOf(const Sun& sun) {
  Lamp lamp;
  lamp.kind = Lamp::Kind::kSun;
  lamp.direction = -sun.towards.normalized();
  lamp.intensity = sun.irradiance;
  return lamp;
}

const FieldTable& sunFields() {
  using enum FieldType;
  // clang-format off: a row is read as one
  static const FieldRow kFields[] = {
      {.name = "direction", .type = kDirection,
       .access = customMember<Sun, sunDirection, setSunDirection>(),
       .help = "direction in which its light travels, so the third number is negative; it is "
               "scattered once, with shadows from the scattering medium", .required = true,
       .option = {"X,Y,Z", "sun"},
       .slider = {.label = "direction"}},
      {.name = "radiance", .type = kColor, .access = member<&Sun::irradiance>(),
       .help = "radiance arriving on a surface that faces the sun", .least = 0,
       .option = {.value = "R,G,B", .name = "sun-radiance", .beside = "sun"},
       .slider = {.label = "irradiance"}}};
  // clang-format on
  static const FieldTable kTable =
      fieldTable<Sun>({.name = "sun",
                       .sentence = "a distant light with parallel rays",
                       .fields = kFields,
                       .kind = "sun"});
  return kTable;
}

std::span<const FieldTable* const> lightTables() {
  static const FieldTable* const kTables[] = {&sunFields(), &spotFields(), &ambientFields()};
  return kTables;
}

Result<SceneLights> parseLights(const nlohmann::json& json, const FieldOrigin& origin) {
  if (!json.is_array())
    return origin.wrong("expected a list");
  SceneLights lights;
  for (std::size_t i = 0; i < json.size(); ++i)
    VOLUTE_TRY(addLight(json[i], {origin.file, fmt::format("{}/{}", origin.path, i)}, lights));
  return lights;
}

}  // namespace volute
