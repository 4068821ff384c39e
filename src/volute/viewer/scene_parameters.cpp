// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/scene_parameters.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "volute/fds/smv_index.hpp"
#include "volute/optics/smoke_potential.hpp"

namespace volute {
namespace {

using Json = nlohmann::ordered_json;
using Kind = Parameter::Kind;

constexpr const char* kAlbedoHelp = "share of the extinction that scatters light; the rest absorbs";

std::vector<double> numbers(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

std::vector<double> numbers(const Rgb& c) {
  return {c[0], c[1], c[2]};
}

std::vector<std::string> smokeQuantities() {
  return {"soot-density",    "products-density",   "extinction",
          "optical-density", "optical-density-db", "visibility"};
}

double placeIn(const std::vector<std::string>& names, std::string_view name) {
  const auto found = std::ranges::find(names, name);
  return found == names.end() ? 0 : static_cast<double>(found - names.begin());
}

/// Collects the parameters of one object.
class Group {
 public:
  Group(std::vector<Parameter>& out, std::string name, std::string path)
      : out_(out), name_(std::move(name)), path_(std::move(path)) {}

  Parameter& add(const char* name, const char* key, Kind kind, std::vector<double> value) {
    out_.push_back({name_, name, path_ + "/" + key, kind, std::move(value)});
    return out_.back();
  }

  /// From 0, the more finely the nearer to it.
  Parameter& amount(const char* name, const char* key, double value, double most,
                    const char* unit) {
    Parameter& made = add(name, key, Kind::kNumber, {value});
    made.most = std::max(most, 2 * value);
    made.logarithmic = true;
    made.unit = unit;
    return made;
  }

  Parameter& range(const char* name, const char* key, double value, double least, double most,
                   const char* unit = "") {
    Parameter& made = add(name, key, Kind::kNumber, {value});
    made.least = std::min(least, value), made.most = std::max(most, value);
    made.unit = unit;
    return made;
  }

  Parameter& choice(const char* name, const char* key, std::vector<std::string> choices,
                    std::string_view value) {
    Parameter& made = add(name, key, Kind::kChoice, {placeIn(choices, value)});
    made.most = static_cast<double>(choices.size()) - 1;
    made.choices = std::move(choices);
    return made;
  }

 private:
  std::vector<Parameter>& out_;
  std::string name_, path_;
};

std::string nameOfFile(const std::string& file) {
  return std::filesystem::path(file).filename().string();
}

void addVolume(Group group, const SceneVolume& volume) {
  group.amount("emission", "emission", volume.appearance.emission, 100, "/m").help =
      "radiance per metre where the volume's value is 1";
  group.amount("extinction", "extinction", volume.appearance.extinction, 100, "/m").help =
      "where the volume's value is 1";
}

void addFog(Group group, const Json& json, const FogDescription& fog, bool suns) {
  group.amount("densest", "sigma_max", fog.placement.sigmaMax, 1, "/m").help =
      "extinction of a white pixel of the map";
  group.range("mu", "mu", fog.options.detail.mu, 0, 1).help =
      "each coarser level is used from this share of the distance on; 1 keeps all details";
  const auto integer = [&](const char* name, const char* key, int value, int most) -> Parameter& {
    Parameter& made = group.add(name, key, Kind::kInteger, {static_cast<double>(value)});
    made.most = most;
    return made;
  };
  integer("levels", "levels", fog.options.levels, std::max(6, fog.options.levels)).help =
      "how often the map is halved";
  integer("degree", "degree", fog.options.degree, kMostSplineDegree).help = "of the splines";
  group.add("colour", "color", Kind::kColor, numbers(fog.options.color)).help =
      "radiance of fog that one cannot see through";
  if (suns) {
    group.add("albedo", "albedo", Kind::kColor, numbers(fog.scattering.albedo)).help = kAlbedoHelp;
    group.range("asymmetry", "asymmetry", fog.scattering.asymmetry, -0.9, 0.9).help =
        "mean cosine of the angle that light is scattered by: above 0 forward";
  }
  const Json profile = json.value("profile", Json::object());
  const std::string kind = profile.value("kind", "");
  if (kind == "slab") {
    group.range("bottom", "profile/bottom", profile.value("bottom", 0.0), -20, 20, "m");
    group.range("top", "profile/top", profile.value("top", 10.0), 0, 100, "m");
  } else if (kind == "exponential") {
    group.range("bottom", "profile/bottom", profile.value("bottom", 0.0), -20, 20, "m");
    group.range("scale height", "profile/height", profile.value("height", 20.0), 1, 200, "m");
  }
}

void addSmoke(Group group, const SmokeDescription& smoke) {
  const SmokeModel& model = smoke.model;
  const bool fds = isSmvPath(smoke.file);
  if (!fds && model.quantity != SmokeQuantity::kMassFraction)
    group.choice("field holds", "quantity", smokeQuantities(), nameOf(model.quantity));
  const bool soot = model.quantity == SmokeQuantity::kSootDensity;
  const bool products = model.quantity == SmokeQuantity::kProductsDensity;
  if (!fds && (soot || products)) {
    group.choice("unit", "unit", {"kg/m3", "g/m3", "mg/m3"},
                 model.unit == 1e-3   ? "g/m3"
                 : model.unit == 1e-6 ? "mg/m3"
                                      : "kg/m3");
  }
  group.amount("scale", "scale", model.scale, 10, "x").help =
      "the field is multiplied by this before anything else";
  if (products) {
    const double potential =
        model.smokePotential.value_or(smokePotential(model.massExtinction, model.sootYield));
    group.amount("smoke potential", "smoke_potential", potential, 10, "dB m2/g").help =
        "of what burns; the list has that of materials";
    std::vector<std::string> materials{"-"};
    std::string_view of = "-";
    for (const SmokePotential& entry : smokePotentials()) {
      materials.emplace_back(entry.material);
      if (entry.flaming == potential)
        of = entry.material;
    }
    group.choice("material", "material", std::move(materials), of).help =
        "takes its smoke potential when flaming";
  } else if (fds || soot || model.quantity == SmokeQuantity::kMassFraction) {
    group.range("Km", "mass_extinction", model.massExtinction, 1000, 15000, "m2/kg").help =
        fds ? "extinction of 1 kg/m3 of soot; where the case holds opacity or extinction it says "
              "nothing"
            : "extinction of 1 kg/m3 of soot, natural logarithm";
  }
  group.choice("mode", "mode", {"photometric", "threshold"}, nameOf(smoke.law.mode)).help =
      "threshold: what has faded to a tenth is no longer seen";
  group.range("C", "C", smoke.law.c, 1, 10).help = "visibility = C / K: 3 reflecting, 8 emitting";
  group.add("albedo", "albedo", Kind::kColor, numbers(smoke.albedo)).help = kAlbedoHelp;
}

void addMedia(std::vector<Parameter>& out, const Json& json, const SceneDescription& scene) {
  std::size_t volumes = 0, fogs = 0, smokes = 0;
  const Json media = json.value("media", Json::array());
  for (std::size_t i = 0; i < media.size(); ++i) {
    const std::string path = fmt::format("/media/{}", i);
    const std::string kind = media[i].at("kind");
    if (kind == "volume") {
      const SceneVolume& volume = scene.volumes[volumes++];
      addVolume({out, "volume: " + nameOfFile(volume.file), path}, volume);
    } else if (kind == "fog") {
      const FogDescription& fog = scene.fogs[fogs++];
      addFog({out, "fog: " + nameOfFile(fog.maps.front()), path}, media[i], fog,
             !scene.lights.suns.empty());
    } else {
      const SmokeDescription& smoke = scene.smokes[smokes++];
      addSmoke({out, "smoke: " + nameOfFile(smoke.file), path}, smoke);
    }
  }
}

void addLights(std::vector<Parameter>& out, const Json& lights) {
  for (std::size_t i = 0; i < lights.size(); ++i) {
    const std::string kind = lights[i].at("kind");
    Group group(out, lights.size() == 1 ? kind : fmt::format("{} {}", kind, i + 1),
                fmt::format("/lights/{}", i));
    const auto vector = [&](const char* key, std::vector<double> usual) {
      return lights[i].value(key, std::move(usual));
    };
    if (kind == "sun") {
      group.add("direction", "direction", Kind::kDirection, vector("direction", {0, 0, -1}));
      group.add("irradiance", "radiance", Kind::kColor, vector("radiance", {1, 1, 1})).help =
          "what arrives on a surface that faces the sun";
    } else if (kind == "ambient") {
      group.add("radiance", "radiance", Kind::kColor, vector("radiance", {0, 0, 0})).help =
          "from everywhere";
    } else {
      group.add("position", "position", Kind::kPoint, vector("position", {0, 0, 0})).unit = "m";
      group.add("target", "target", Kind::kPoint, vector("target", {0, 0, 0})).unit = "m";
      group.range("cone", "angle", lights[i].value("angle", 60.0), 1, 179, "degrees").help =
          "from side to side";
      group.add("intensity", "intensity", Kind::kColor, vector("intensity", {1, 1, 1})).help =
          "power per solid angle";
    }
  }
}

void addSigns(std::vector<Parameter>& out, const Json& signs, const SceneDescription& scene) {
  for (std::size_t i = 0; i < scene.signs.size(); ++i) {
    const Sign& sign = scene.signs[i];
    Group group(out, "sign: " + (sign.name.empty() ? fmt::format("{}", i + 1) : sign.name),
                fmt::format("/signs/{}", i));
    group.add("position", "position", Kind::kPoint, numbers(sign.position)).unit = "m";
    group.add("normal", "normal", Kind::kDirection, numbers(sign.normal));
    group.add("emits light", "emitting", Kind::kFlag,
              {signs[i].value("emitting", false) ? 1.0 : 0.0});
    group.range("C", "C", sign.c, 1, 10).help = "no longer seen at this optical depth";
    group.range("width", "size/0", sign.width, 0.05, 3, "m");
    group.range("height", "size/1", sign.height, 0.05, 3, "m");
  }
}

/// What a field's new meaning needs, and what it must not have.
void takeQuantity(Json& smoke, const std::string& quantity) {
  for (const char* key : {"material", "burning", "smoke_potential", "soot_yield", "density_field"})
    smoke.erase(key);
  if (quantity != "soot-density")
    smoke.erase("mass_extinction");
  if (quantity != "soot-density" && quantity != "products-density")
    smoke.erase("unit");
  smoke["quantity"] = quantity;
  if (quantity == "products-density")
    smoke["smoke_potential"] = 1.0;
}

Status checkValue(const Parameter& parameter, const std::vector<double>& value) {
  const bool finite = std::ranges::all_of(value, [](double v) { return std::isfinite(v); });
  if (value.size() == parameter.value.size() && finite)
    return {};
  return fail(ErrorCode::kInvalidArgument, "{}: expected {} finite numbers", parameter.path,
              parameter.value.size());
}

Json jsonOf(const Parameter& parameter, const std::vector<double>& value) {
  switch (parameter.kind) {
    case Kind::kFlag:
      return value.front() != 0;
    case Kind::kInteger:
      return static_cast<int>(std::lround(value.front()));
    case Kind::kChoice:
      return parameter.choices.at(
          static_cast<std::size_t>(std::clamp(std::round(value.front()), 0.0, parameter.most)));
    case Kind::kNumber:
      return value.front();
    default:
      return value;
  }
}

}  // namespace

std::vector<Parameter> sceneParameters(const Json& json, const SceneDescription& scene) {
  std::vector<Parameter> out;
  addMedia(out, json, scene);
  addLights(out, json.value("lights", Json::array()));
  addSigns(out, json.value("signs", Json::array()), scene);
  Group group(out, "background", "");
  group.add("radiance", "background", Kind::kColor, numbers(scene.background)).help =
      "behind everything";
  return out;
}

Status setParameter(Json& json, const SceneDescription& scene, const std::string& path,
                    const std::vector<double>& value) {
  const auto all = sceneParameters(json, scene);
  const auto found = std::ranges::find(all, path, &Parameter::path);
  if (found == all.end())
    return fail(ErrorCode::kInvalidArgument, "{}: the scene has no such parameter", path);
  VOLUTE_TRY(checkValue(*found, value));
  const Json put = jsonOf(*found, value);
  const Json::json_pointer pointer(path);
  const std::string key = pointer.back();
  if (path.find("/size/") != std::string::npos) {
    Json& size = json[pointer.parent_pointer()];
    if (size.is_null())
      size = {Sign{}.width, Sign{}.height};
    size[key == "0" ? 0 : 1] = put;
    return {};
  }
  Json& object = json[pointer.parent_pointer()];
  const bool smoke = path.starts_with("/media/") && object.value("kind", "") == "smoke";
  if (smoke && (key == "mode" || key == "C")) {
    for (Json& medium : json["media"]) {
      if (medium.value("kind", "") == "smoke")
        medium[key] = put;
    }
    return {};
  }
  if (smoke && key == "quantity") {
    takeQuantity(object, put);
    return {};
  }
  if (smoke && (key == "smoke_potential" || key == "material")) {
    for (const char* other : {"material", "burning", "soot_yield", "mass_extinction"})
      object.erase(other);
    if (key == "smoke_potential")
      object[key] = put;
    else if (const auto entry = smokePotentialOf(put.get<std::string>()))
      object["smoke_potential"] = entry->flaming;
    return {};
  }
  if (path.starts_with("/signs/") && key == "emitting")
    object.erase("C");
  object[key] = put;
  return {};
}

}  // namespace volute
