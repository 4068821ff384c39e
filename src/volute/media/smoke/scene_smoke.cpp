// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/smoke/scene_smoke.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>

#include "volute/base/file_name.hpp"
#include "volute/base/input_file.hpp"
#include "volute/io/mesh_source.hpp"
#include "volute/media/clock_fields.hpp"
#include "volute/media/law_rows.hpp"
#include "volute/media/smoke/mesh_air.hpp"
#include "volute/media/smoke/smoke_parameters.hpp"
#include "volute/media/smoke/smoke_words.hpp"
#include "volute/optics/smoke_potential.hpp"

namespace volute {
namespace {

using Json = nlohmann::json;

constexpr std::string_view kDensityUnits[] = {"kg/m3", "g/m3", "mg/m3"};

FieldValue unitName(const SmokeDescription& smoke) {
  for (const std::string_view name : kDensityUnits) {
    if (densityUnit(name) == smoke.model.unit)
      return name;
  }
  return {};
}

Status setUnit(SmokeDescription& smoke, const FieldValue& value) {
  VOLUTE_ASSIGN(smoke.model.unit, densityUnit(value.get<std::string>()));
  return {};
}

/// The material becomes its smoke potential, once all is read.
FieldValue noMaterial(const SmokeDescription& /*smoke*/) {
  return {};
}

Status leaveMaterial(SmokeDescription& /*smoke*/, const FieldValue& /*name*/) {
  return {};
}

FieldValue yieldOf(const SmokeDescription& smoke) {
  return smoke.model.sootYield == 0 ? FieldValue() : FieldValue(smoke.model.sootYield);
}

Status setYield(SmokeDescription& smoke, const FieldValue& value) {
  smoke.model.sootYield = value.get<double>();
  return {};
}

FieldValue wallsOf(const SmokeDescription& smoke) {
  if (!smoke.walls)
    return false;
  return {(*smoke.walls)[0], (*smoke.walls)[1], (*smoke.walls)[2]};
}

Status setWalls(SmokeDescription& smoke, const FieldValue& value) {
  if (value == false)
    smoke.walls.reset();
  else if (value == true)
    smoke.walls = Rgb::Constant(0.7);
  else
    smoke.walls = Rgb(value[0].get<double>(), value[1].get<double>(), value[2].get<double>());
  return {};
}

bool ofSoot(const void* smoke, const MediumFacts& /*facts*/) {
  const SmokeQuantity quantity = static_cast<const SmokeDescription*>(smoke)->model.quantity;
  return quantity == SmokeQuantity::kSootDensity || quantity == SmokeQuantity::kMassFraction;
}

/// The smoke potential of the material that is said.
Status takeMaterial(const Json& json, const FieldOrigin& origin, SmokeModel& model) {
  const FieldTable& table = smokeFields();
  if (!json.contains("material")) {
    return json.contains("burning") ? Status(origin.wrong(table.at("burning"), "is for a material"))
                                    : Status();
  }
  if (json.contains("smoke_potential"))
    return origin.wrong(table.at("smoke_potential"), "the material has one already; leave one out");
  if (model.quantity != SmokeQuantity::kProductsDensity) {
    return origin.wrong(table.at("material"),
                        fmt::format("is for the quantity products-density, not for {}: a "
                                    "material's smoke potential tells how much of what burns "
                                    "becomes soot",
                                    nameOf(model.quantity)));
  }
  const auto potential = smokePotentialOf(json["material"].get<std::string>());
  if (!potential)
    return origin.wrong(table.at("material"), potential.error().message);
  VOLUTE_ASSIGN(const Burning how, burning(json.value("burning", "flaming")));
  model.smokePotential = potential->value(how);
  return {};
}

/// What is wrong, and the member that it is about; null: nothing.
struct SmokeObjection {
  const char* about = nullptr;
  std::string message{};
};

/// Members about a field that holds something else.
SmokeObjection idleMember(const SmokeDescription& smoke, const Json& json) {
  const SmokeModel& model = smoke.model;
  const std::string_view name = nameOf(model.quantity);
  const bool products = model.quantity == SmokeQuantity::kProductsDensity;
  if (json.contains("unit") && model.quantity != SmokeQuantity::kSootDensity && !products)
    return {"unit", fmt::format("is for densities, and {} is in {}; leave it out", name,
                                unitOfField(model))};
  if (json.contains("mass_extinction") && !holdsMass(model.quantity))
    return {"mass_extinction",
            fmt::format("is of soot, and {} is what smoke does to light already; leave it out, or "
                        "say what mass the field holds",
                        name)};
  if (model.sootYield != 0 && !products)
    return {"soot_yield",
            fmt::format("is for products-density, and {}; leave it out",
                        holdsMass(model.quantity)
                            ? fmt::format("{} is soot alone", name)
                            : fmt::format("{} is what smoke does to light already", name))};
  if (model.smokePotential && !products)
    return {"smoke_potential", fmt::format("is for products-density, not for {}", name)};
  if (model.smokePotential && (model.sootYield != 0 || json.contains("mass_extinction")))
    return {model.sootYield != 0 ? "soot_yield" : "mass_extinction",
            fmt::format("the {} takes its place; leave one of them out",
                        json.contains("material") ? "material" : "smoke potential")};
  if (!smoke.densityField.empty() && model.quantity != SmokeQuantity::kMassFraction)
    return {"density_field", fmt::format("is for mass-fraction, not for {}", name)};
  if (smoke.densityField.empty() && model.quantity == SmokeQuantity::kMassFraction)
    return {"density_field",
            "is missing; mass-fraction needs the field of the gas's density [kg/m3]"};
  if (const auto good = model.check(); !good)
    return {"quantity", good.error().message};
  return {};
}

}  // namespace

const FieldTable& smokeFields() {
  using enum FieldType;
  using Smoke = SmokeDescription;
  static constexpr std::string_view kQuantities[] = {
      "soot-density",    "products-density",   "mass-fraction", "extinction",
      "optical-density", "optical-density-db", "visibility"};
  static constexpr std::string_view kBurnings[] = {"flaming", "smouldering"};
  static constexpr std::string_view kNegatives[] = {"refuse", "clamp"};
  FieldRow massExtinction = massExtinctionRow(member<&Smoke::model, &SmokeModel::massExtinction>());
  massExtinction.slider.shown = ofSoot;
  // clang-format off: a row is read as one
  static const FieldRow kFields[] = {
      {.name = "case", .type = kFile, .access = member<&Smoke::file>(),
       .help = "a .vtu, .pvtu or .vtk file, a .pvd series, or an EnSight (.case), Exodus (.e) or "
               "OpenFOAM (.foam) case",
       .required = true, .pattern = R"(^(?!.*\.[sS][mM][vV]$))"},
      {.name = "field", .type = kText, .access = member<&Smoke::field>(),
       .help = "grid or field of a file with several", .option = {"NAME"}},
      {.name = "quantity", .type = kChoice,
       .access = member<&Smoke::model, &SmokeModel::quantity>(),
       .help = "quantity that the field contains",
       .choices = kQuantities, .required = true, .option = {"NAME"},
       .slider = {.label = "field holds", .custom = addQuantity}},
      {.name = "unit", .type = kChoice, .access = customMember<Smoke, unitName, setUnit>(),
       .help = "of a density", .choices = kDensityUnits, .option = {"NAME"},
       .slider = {.label = "unit", .custom = addUnit}},
      scaleRow(member<&Smoke::model, &SmokeModel::scale>()),
      {.name = "smoke_potential", .access = member<&Smoke::model, &SmokeModel::smokePotential>(),
       .help = "of the fuel, for products-density; replaces soot yield and mass extinction",
       .unit = "dB m2/g", .least = 0,
       .slider = {.label = "smoke potential", .least = 0, .most = 10, .logarithmic = true,
                  .room = 2, .custom = addPotential}},
      {.name = "material", .type = kText,
       .access = customMember<Smoke, noMaterial, leaveMaterial>(),
       .help = "burning material with a known smoke potential; replaces soot yield and mass "
               "extinction", .option = {"NAME"}},
      {.name = "burning", .type = kChoice,
       .access = customMember<Smoke, noMaterial, leaveMaterial>(),
       .help = "how the material burns; flaming if not given", .choices = kBurnings,
       .option = {"HOW"}},
      {.name = "soot_yield", .access = customMember<Smoke, yieldOf, setYield>(),
       .help = "mass of soot per mass burnt, for products-density", .least = 0, .most = 1,
       .above = true, .option = {"YS"}},
      {.name = "density_field", .type = kText, .access = member<&Smoke::densityField>(),
       .help = "field with the density of the gas, for mass-fraction", .unit = "kg/m3",
       .option = {"NAME"}},
      {.name = "air_fields", .type = kText, .access = member<&Smoke::airFields>(),
       .help = "fields with what people breathe and stand in, and their units: "
               "temperature=T:K,oxygen=O2:%; fields with usual names (T, O2, CO2, CO) are found "
               "without it", .option = {"LIST"}},
      massExtinction, modeRow<Smoke>(), lawCRow<Smoke>(), albedoRow<Smoke>(),
      {.name = "negatives", .type = kChoice, .access = member<&Smoke::negatives>(),
       .help = "clamp: treat negative values of the field as 0", .choices = kNegatives,
       .option = {.name = "clamp", .flagValue = "clamp"}},
      {.name = "walls", .type = kColor, .access = customMember<Smoke, wallsOf, setWalls>(),
       .help = "true or a colour: show the mesh's boundary from inside, lit", .least = 0,
       .most = 1, .flagToo = true},
      clockField<&Smoke::clock>()};
  // clang-format on
  static const FieldTable kTable = fieldTable<Smoke>({.name = "smoke",
                                                      .sentence = "smoke on a mesh",
                                                      .fields = kFields,
                                                      .kind = "smoke",
                                                      .thing = "smoke on a mesh",
                                                      .things = "smoke on meshes"});
  return kTable;
}

Result<SmokeDescription> parseSmoke(const Json& json, const FieldOrigin& origin) {
  VOLUTE_ASSIGN(auto smoke, readAs<SmokeDescription>(smokeFields(), json, origin));
  smoke.origin = origin;
  VOLUTE_TRY(takeMaterial(json, origin, smoke.model));
  if (const auto air = parseMeshAir(smoke.airFields); !air)
    return origin.wrong(smokeFields().at("air_fields"), air.error().message);
  const SmokeObjection idle = idleMember(smoke, json);
  if (idle.about)
    return origin.wrong(smokeFields().at(idle.about), idle.message);
  return smoke;
}

bool isSmokeCase(const std::string& path) {
  const std::string extension = extensionOf(path);
  if (extension == ".vtu" || isMeshCase(path))
    return true;
  if (extension != ".pvd")
    return false;
  // A collection of meshes or of images: the first names decide.
  const auto file = InputFile::open(path);
  if (!file)
    return false;  // who reads it says so
  std::string text(std::min<std::uint64_t>(file->size(), 64 << 10), '\0');
  if (!file->read(0, std::as_writable_bytes(std::span(text))))
    return false;
  const auto mesh = std::min(text.find(".vtu"), text.find(".pvtu")), image = text.find(".vti");
  return mesh < image;
}

}  // namespace volute
