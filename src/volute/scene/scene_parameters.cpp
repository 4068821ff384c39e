// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/scene_parameters.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "volute/fds/smv_index.hpp"
#include "volute/optics/smoke_potential.hpp"
#include "volute/scene/fog_parameters.hpp"
#include "volute/scene/placement_parameters.hpp"
#include "volute/scene/smoke_layer.hpp"

namespace volute {
namespace {

using OrderedJson = nlohmann::ordered_json;
using ParameterKind = Parameter::Kind;
using Group = ParameterGroup;

constexpr const char* kAlbedoHelp = "share of the extinction that scatters light; the rest absorbs";

std::vector<double> numbers(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

std::vector<double> numbers(const Rgb& c) {
  return {c[0], c[1], c[2]};
}

constexpr int kExtinctionPlace = 2;  ///< its place

std::vector<std::string> smokeQuantities() {
  return {"soot-density",    "products-density",   "extinction",
          "optical-density", "optical-density-db", "visibility"};
}

std::string nameOfFile(const std::string& file) {
  return std::filesystem::path(file).filename().string();
}

/// Of media and boards in the order of a list; nothing is known of what is not there.
MediumFacts factsAt(const std::vector<MediumFacts>& all, std::size_t i) {
  return i < all.size() ? all[i] : MediumFacts{};
}

void addEmission(Group& group, const Appearance& look) {
  group.amount("emission", "emission", look.emission, 100, "/m").help =
      "radiance per metre where the volume's value is 1";
  group.amount("extinction", "extinction", look.extinction, 100, "/m").help =
      "where the volume's value is 1";
}

void addVolume(Group group, const SceneVolume& volume, const MediumFacts& facts) {
  addEmission(group, volume.appearance);
  addPlacement(group, volume.appearance.placement, facts.bounds);
  group.clock(volume.appearance.clock, facts);
}

/// A volume as a picture of itself that turns to the eye.
void addBillboard(Group group, const SceneBillboard& board, const MediumFacts& facts) {
  addEmission(group, board.appearance);
  const BillboardOptions& options = board.options;
  group
      .choice("hides", "alpha", {"transmittance", "intensity"},
              options.alpha == BillboardAlpha::kIntensity ? "intensity" : "transmittance")
      .help =
      "what is behind it: by what the volume lets through, or, for fire that does not "
      "absorb, by how bright it is";
  group.integer("rows", "rows", options.rows, 16, 512).help = "of its texture";
  group.section("placement");
  const double size = std::hypot(options.width, options.height);
  group.point("middle", "position", options.position, "m", size / 500).help = "of the rectangle";
  group.range("width", "size/0", options.width, 0.05, 10, "m").logarithmic = true;
  Parameter& height = group.range("height", "size/1", options.height, 0.05, 10, "m");
  height.logarithmic = true;
  height.help = "the volume's own height fills it";
  group.section("");
  group.clock(board.appearance.clock, facts);
}

/// What a field means is doubted where no fire has as much soot, or as little; the meanings that
/// make sense are offered.
struct Doubt {
  std::string text{};
  std::vector<int> units{};  ///< places in kUnits
  bool extinction = false;   ///< its values make sense as 1/m
};

constexpr const char* kUnits[] = {"kg/m3", "g/m3", "mg/m3"};
constexpr double kUnitKilograms[] = {1, 1e-3, 1e-6};

Doubt doubtOf(const SmokeModel& model, const MediumFacts& facts) {
  constexpr double kFaint = 0.01, kThick = 50;  // [1/m] that smoke may have
  const double soot = facts.largestExtinction > 0 ? model.sootDensity(facts.largestExtinction) : 0;
  const auto usual = [](double density) {
    return density >= SmokeLayer::kLittleSoot && density <= SmokeLayer::kMuchSoot;
  };
  if (!(soot > 0) || usual(soot))
    return {};
  Doubt doubt{.text = fmt::format("up to {:.2g} kg/m3 of soot, {} for a fire", soot,
                                  soot > SmokeLayer::kMuchSoot ? "much" : "little")};
  for (int i = 0; i < 3; ++i) {
    if (kUnitKilograms[i] != model.unit && usual(soot * kUnitKilograms[i] / model.unit))
      doubt.units.push_back(i);
  }
  const double largest = soot / model.unit;  // of soot, times its scale
  doubt.extinction =
      model.quantity == SmokeQuantity::kSootDensity && largest >= kFaint && largest <= kThick;
  return doubt;
}

void addSmoke(Group group, const SmokeDescription& smoke, const MediumFacts& facts) {
  const SmokeModel& model = smoke.model;
  const bool fds = isSmvPath(smoke.file);
  const Doubt doubt = doubtOf(model, facts);
  if (!fds && model.quantity != SmokeQuantity::kMassFraction) {
    Parameter& quantity =
        group.choice("field holds", "quantity", smokeQuantities(), nameOf(model.quantity));
    quantity.help = "what its values mean; of concentrations also the unit below";
    if (doubt.extinction) {
      quantity.doubt = doubt.text + ": does the field hold";
      quantity.offers = {kExtinctionPlace};
    }
  }
  const bool soot = model.quantity == SmokeQuantity::kSootDensity;
  const bool products = model.quantity == SmokeQuantity::kProductsDensity;
  if (!fds && (soot || products)) {
    const auto held = std::ranges::find(kUnitKilograms, model.unit) - kUnitKilograms;
    Parameter& unit = group.choice("unit", "unit", {std::begin(kUnits), std::end(kUnits)},
                                   kUnits[held == std::ssize(kUnits) ? 0 : held]);
    if (!doubt.units.empty()) {
      unit.doubt = doubt.extinction ? "or is its unit" : doubt.text + ": is its unit";
      unit.offers = doubt.units;
    }
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
  group.add("albedo", "albedo", ParameterKind::kColor, numbers(smoke.albedo)).help = kAlbedoHelp;
  group.clock(smoke.clock, facts);
}

void addMedia(std::vector<Parameter>& out, const OrderedJson& json, const SceneDescription& scene,
              const SceneFacts& facts) {
  std::size_t volumes = 0, fogs = 0, smokes = 0;
  const OrderedJson media = json.value("media", OrderedJson::array());
  for (std::size_t i = 0; i < media.size(); ++i) {
    const std::string path = fmt::format("/media/{}", i);
    const std::string kind = media[i].at("kind");
    if (kind == "volume") {
      const SceneVolume& volume = scene.volumes[volumes++];
      addVolume({out, "volume: " + nameOfFile(volume.file), path}, volume, factsAt(facts.media, i));
    } else if (kind == "fog") {
      const FogDescription& fog = scene.fogs[fogs++];
      addFog({out, "fog: " + nameOfFile(fog.maps.front()), path}, media[i], fog,
             !scene.lights.suns.empty(), factsAt(facts.media, i));
    } else {
      const SmokeDescription& smoke = scene.smokes[smokes++];
      addSmoke({out, "smoke: " + nameOfFile(smoke.file), path}, smoke, factsAt(facts.media, i));
    }
  }
  for (std::size_t i = 0; i < scene.billboards.size(); ++i) {
    const SceneBillboard& board = scene.billboards[i];
    addBillboard({out, "billboard: " + nameOfFile(board.file), fmt::format("/billboards/{}", i)},
                 board, factsAt(facts.billboards, i));
  }
}

void addLights(std::vector<Parameter>& out, const OrderedJson& lights) {
  for (std::size_t i = 0; i < lights.size(); ++i) {
    const std::string kind = lights[i].at("kind");
    Group group(out, lights.size() == 1 ? kind : fmt::format("{} {}", kind, i + 1),
                fmt::format("/lights/{}", i));
    const auto vector = [&](const char* key, std::vector<double> usual) {
      return lights[i].value(key, std::move(usual));
    };
    if (kind == "sun") {
      group.add("direction", "direction", ParameterKind::kDirection, vector("direction", {0, 0, -1}));
      group.add("irradiance", "radiance", ParameterKind::kColor, vector("radiance", {1, 1, 1})).help =
          "what arrives on a surface that faces the sun";
    } else if (kind == "ambient") {
      group.add("radiance", "radiance", ParameterKind::kColor, vector("radiance", {0, 0, 0})).help =
          "from everywhere";
    } else {
      group.add("position", "position", ParameterKind::kPoint, vector("position", {0, 0, 0})).unit = "m";
      group.add("target", "target", ParameterKind::kPoint, vector("target", {0, 0, 0})).unit = "m";
      group.range("cone", "angle", lights[i].value("angle", 60.0), 1, 179, "degrees").help =
          "from side to side";
      group.add("intensity", "intensity", ParameterKind::kColor, vector("intensity", {1, 1, 1})).help =
          "power per solid angle";
    }
  }
}

void addSigns(std::vector<Parameter>& out, const OrderedJson& signs, const SceneDescription& scene) {
  for (std::size_t i = 0; i < scene.signs.size(); ++i) {
    const Sign& sign = scene.signs[i];
    Group group(out, "sign: " + (sign.name.empty() ? fmt::format("{}", i + 1) : sign.name),
                fmt::format("/signs/{}", i));
    group.add("position", "position", ParameterKind::kPoint, numbers(sign.position)).unit = "m";
    group.add("normal", "normal", ParameterKind::kDirection, numbers(sign.normal));
    group.add("emits light", "emitting", ParameterKind::kFlag,
              {signs[i].value("emitting", false) ? 1.0 : 0.0});
    // A string's assignment from a literal is what GCC 12 warns of in vain (bug 105651).
    group.range("C", "C", sign.c, 1, 10).help = std::string("no longer seen at this optical depth");
    group.range("width", "size/0", sign.width, 0.05, 3, "m");
    group.range("height", "size/1", sign.height, 0.05, 3, "m");
  }
}

/// What a field's new meaning needs, and what it must not have.
void takeQuantity(OrderedJson& smoke, const std::string& quantity) {
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

OrderedJson jsonOf(const Parameter& parameter, const std::vector<double>& value) {
  switch (parameter.kind) {
    case ParameterKind::kFlag:
      return value.front() != 0;
    case ParameterKind::kInteger:
      return static_cast<int>(std::lround(value.front()));
    case ParameterKind::kChoice:
      return parameter.choices.at(
          static_cast<std::size_t>(std::clamp(std::round(value.front()), 0.0, parameter.most)));
    case ParameterKind::kNumber:
      return value.front();
    default:
      return value;
  }
}

/// How many media of its kind come before one: its place in the scene's list of them.
std::size_t placeAmongItsKind(const OrderedJson& media, std::size_t i) {
  const std::string kind = media[i].at("kind");
  return static_cast<std::size_t>(
      std::count_if(media.begin(), media.begin() + static_cast<std::ptrdiff_t>(i),
                    [&](const OrderedJson& medium) { return medium.at("kind") == kind; }));
}

/// Values that more than one number of the file stands for. False, with nothing done, for others.
bool setInMedium(OrderedJson& json, const SceneDescription& scene, const SceneFacts& facts,
                 const std::string& path, const std::vector<double>& value) {
  const std::size_t begin = std::string_view("/media/").size();
  const std::size_t end = path.find('/', begin);
  const std::size_t i = std::stoul(path.substr(begin, end - begin));
  const std::string key = path.substr(end + 1);
  OrderedJson& medium = json["media"][i];
  const std::size_t place = placeAmongItsKind(json["media"], i);
  if (medium["kind"] == "fog")
    return setFog(medium, scene.fogs[place], key, value);
  if (!key.starts_with("transform/"))
    return false;
  setPlacement(medium, scene.volumes[place].appearance.placement, factsAt(facts.media, i).bounds,
               key.substr(key.find('/') + 1), value);
  return true;
}

}  // namespace

std::vector<Parameter> sceneParameters(const OrderedJson& json, const SceneDescription& scene,
                                       const SceneFacts& facts) {
  std::vector<Parameter> out;
  addMedia(out, json, scene, facts);
  addLights(out, json.value("lights", OrderedJson::array()));
  addSigns(out, json.value("signs", OrderedJson::array()), scene);
  Group group(out, "background", "");
  group.add("radiance", "background", ParameterKind::kColor, numbers(scene.background)).help =
      "behind everything";
  return out;
}

Status setParameter(OrderedJson& json, const SceneDescription& scene, const SceneFacts& facts,
                    const std::string& path, const std::vector<double>& value) {
  const auto all = sceneParameters(json, scene, facts);
  const auto found = std::ranges::find(all, path, &Parameter::path);
  if (found == all.end())
    return fail(ErrorCode::kInvalidArgument, "{}: the scene has no such parameter", path);
  VOLUTE_TRY(checkValue(*found, value));
  if (path.starts_with("/media/") && setInMedium(json, scene, facts, path, value))
    return {};
  const OrderedJson put = jsonOf(*found, value);
  const OrderedJson::json_pointer pointer(path);
  const std::string key = pointer.back();
  if (path.find("/size/") != std::string::npos) {
    OrderedJson& size = json[pointer.parent_pointer()];
    if (size.is_null())
      size = {Sign{}.width, Sign{}.height};
    size[key == "0" ? 0 : 1] = put;
    return {};
  }
  OrderedJson& object = json[pointer.parent_pointer()];
  const bool smoke =
      path.starts_with("/media/") && object.is_object() && object.value("kind", "") == "smoke";
  if (smoke && (key == "mode" || key == "C")) {
    for (OrderedJson& medium : json["media"]) {
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
  json[pointer] = put;
  return {};
}

}  // namespace volute
