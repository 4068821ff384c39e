// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/scene_smoke.hpp"

#include <fstream>

#include "volute/cli/fog_file.hpp"
#include "volute/cli/json_members.hpp"
#include "volute/cli/volume_input.hpp"
#include "volute/fds/smv_index.hpp"
#include "volute/io/mesh_source.hpp"
#include "volute/optics/smoke_potential.hpp"

namespace volute::cli {
namespace {

using Json = nlohmann::json;

/// What scenes and command lines both say; empty texts say nothing.
struct Words {
  std::string quantity, unit, material, burning, mode, c;
};

/// An objection, and the member or option that it is about.
struct Objection {
  const char* about;
  std::string message;
};

tl::unexpected<Objection> object(const char* about, std::string message) {
  return tl::unexpected<Objection>(Objection{about, std::move(message)});
}

template <class T>
tl::expected<void, Objection> take(T& value, Result<T> found, const char* about) {
  if (!found)
    return object(about, found.error().message);
  value = std::move(*found);
  return {};
}

tl::expected<void, Objection> takeMaterial(SmokeModel& model, const Words& words) {
  Burning how = Burning::kFlaming;
  if (!words.burning.empty()) {
    if (auto taken = take(how, burning(words.burning), "burning"); !taken)
      return taken;
  }
  if (words.material.empty()) {
    return words.burning.empty() ? tl::expected<void, Objection>()
                                 : object("burning", "is for a material");
  }
  if (model.quantity != SmokeQuantity::kProductsDensity) {
    return object("material",
                  fmt::format("is for the quantity products-density, not for {}: a material's "
                              "smoke potential tells how much of what burns becomes soot",
                              nameOf(model.quantity)));
  }
  SmokePotential potential{};
  if (auto taken = take(potential, smokePotentialOf(words.material), "material"); !taken)
    return taken;
  model.smokePotential = potential.value(how);
  return {};
}

tl::expected<void, Objection> takeWords(SmokeDescription& smoke, const Words& words) {
  const auto missing = words.quantity.empty();
  const bool saysItself = missing && isSmvPath(smoke.file);
  if (auto taken = saysItself
                       ? tl::expected<void, Objection>()
                       : take(smoke.model.quantity, smokeQuantity(words.quantity), "quantity");
      !taken) {
    return missing ? object("quantity",
                            "is missing; say what the field holds: soot-density, "
                            "products-density, mass-fraction, extinction, optical-density, "
                            "optical-density-db or visibility")
                   : taken;
  }
  if (!words.unit.empty()) {
    if (auto taken = take(smoke.model.unit, densityUnit(words.unit), "unit"); !taken)
      return taken;
  }
  if (auto taken = takeMaterial(smoke.model, words); !taken)
    return taken;
  if (!words.mode.empty()) {
    if (auto taken = take(smoke.law.mode, pictureMode(words.mode), "mode"); !taken)
      return taken;
  }
  if (!words.c.empty()) {
    VisibilityLaw law;
    if (auto taken = take(law, visibilityLaw(words.c), "C"); !taken)
      return taken;
    smoke.model.c = smoke.law.c = law.c;
  }
  if (smoke.model.quantity == SmokeQuantity::kMassFraction && smoke.densityField.empty()) {
    return object("density_field",
                  "is missing; mass-fraction needs the field of the gas's density [kg/m3]");
  }
  if (const auto good = smoke.model.check(); !good)
    return object("quantity", good.error().message);
  return {};
}

/// Texts, and C as a number as well.
Status textOf(const Members& members, const char* key, std::string& value) {
  if (!members.has(key))
    return {};
  if (std::string_view(key) == "C" && members.at(key).is_number()) {
    value = fmt::format("{}", members.at(key).get<double>());
    return {};
  }
  return members.text(key, value, "a name");
}

Status parseWalls(const Members& members, const std::string& file, SmokeDescription& smoke) {
  if (!members.has("walls"))
    return {};
  if (members.at("walls").is_boolean()) {
    if (members.at("walls").get<bool>())
      smoke.walls = Rgb::Constant(0.7);
    return {};
  }
  if (!members.at("walls").is_array())
    return fail(ErrorCode::kInvalidData, "{}: {}: expected true, false or the walls' colour", file,
                members.where("walls"));
  Rgb color = Rgb::Zero();
  VOLUTE_TRY(members.color("walls", color, 1));
  smoke.walls = color;
  return {};
}

Status parseNegatives(const Members& members, const std::string& file, SmokeDescription& smoke) {
  if (!members.has("negatives"))
    return {};
  const Json& given = members.at("negatives");
  if (given != "refuse" && given != "clamp")
    return fail(ErrorCode::kInvalidData, "{}: {}: expected refuse or clamp", file,
                members.where("negatives"));
  smoke.negatives = given == "clamp" ? Negatives::kClamp : Negatives::kRefuse;
  return {};
}

}  // namespace

Result<SmokeDescription> parseSmoke(const Json& json, const std::string& file,
                                    const std::string& path) {
  constexpr std::string_view kNames[] = {
      "kind",  "case",     "field",   "density_field", "quantity", "unit",
      "scale", "material", "burning", "soot_yield",    "C",        "mass_extinction",
      "mode",  "albedo",   "time",    "negatives",     "walls"};
  const Members members(json, file, path);
  VOLUTE_TRY(members.check(kNames));
  SmokeDescription smoke;
  smoke.where = fmt::format("{}: {}", file, path);
  VOLUTE_TRY(members.text("case", smoke.file, "the name of a .vtu file, a .pvd series or a case"));
  smoke.file = besides(file, smoke.file);
  VOLUTE_TRY(textOf(members, "field", smoke.field));
  VOLUTE_TRY(textOf(members, "density_field", smoke.densityField));
  VOLUTE_TRY(members.number("scale", smoke.model.scale));
  VOLUTE_TRY(members.number("mass_extinction", smoke.model.massExtinction));
  VOLUTE_TRY(members.number("soot_yield", smoke.model.sootYield));
  VOLUTE_TRY(members.color("albedo", smoke.albedo, 1));
  VOLUTE_TRY(parseNegatives(members, file, smoke));
  VOLUTE_TRY(parseWalls(members, file, smoke));
  if (members.has("time")) {
    VOLUTE_ASSIGN(smoke.clock, parseClock(members.at("time"), file, members.where("time")));
  }
  Words words;
  const std::pair<const char*, std::string*> texts[] = {
      {"quantity", &words.quantity}, {"unit", &words.unit}, {"material", &words.material},
      {"burning", &words.burning},   {"mode", &words.mode}, {"C", &words.c}};
  for (const auto& [key, text] : texts) VOLUTE_TRY(textOf(members, key, *text));
  if (const auto taken = takeWords(smoke, words); !taken) {
    return fail(ErrorCode::kInvalidData, "{}: {}: {}", file, members.where(taken.error().about),
                taken.error().message);
  }
  return smoke;
}

std::vector<Option> smokeOptions() {
  using enum ValueKind;
  return {{.name = "field",
           .kind = kText,
           .value = "NAME",
           .help = "the field of a smoke case; else its only scalar"},
          {.name = "quantity",
           .kind = kChoice,
           .value = "NAME",
           .help = "what the field of a smoke case holds",
           .choices = {"soot-density", "products-density", "mass-fraction", "extinction",
                       "optical-density", "optical-density-db", "visibility"}},
          {.name = "unit",
           .kind = kChoice,
           .value = "NAME",
           .help = "of a density; else kg/m3",
           .choices = {"kg/m3", "g/m3", "mg/m3"}},
          {.name = "scale",
           .kind = kNumber,
           .value = "S",
           .help = "multiplies the field first",
           .positive = true},
          {.name = "mass-extinction",
           .kind = kNumber,
           .value = "KM",
           .help = "of soot [m2/kg]; else 8700, as FDS has it",
           .positive = true},
          {.name = "soot-yield",
           .kind = kNumber,
           .value = "YS",
           .help = "mass of soot per mass burnt, of products-density",
           .most = 1,
           .positive = true},
          {.name = "material",
           .kind = kText,
           .value = "NAME",
           .help = "what burns, in the place of soot yield and mass extinction"},
          {.name = "burning",
           .kind = kChoice,
           .value = "HOW",
           .help = "how the material burns; else flaming",
           .choices = {"flaming", "smouldering"}},
          {.name = "density-field",
           .kind = kText,
           .value = "NAME",
           .help = "the gas's density [kg/m3], of mass-fraction"},
          {.name = "mode",
           .kind = kChoice,
           .value = "NAME",
           .help = "what a picture of smoke shows: the light that passes, or 10 % of it where "
                   "visibility ends",
           .choices = {"photometric", "threshold"}},
          {.name = "C",
           .kind = kText,
           .value = "C",
           .help = "of threshold, and of a visibility field: jin-reflecting (3), jin-emitting (8), "
                   "reciprocal-od, or a number"},
          {.name = "albedo",
           .kind = kVector,
           .value = "R,G,B",
           .help = "share of the light that smoke scatters; 0.3,0.3,0.3"},
          {.name = "clamp", .help = "take negative values of a smoke field as 0"}};
}

Result<SmokeDescription> smokeOf(const std::string& file, const Arguments& arguments) {
  SmokeDescription smoke;
  smoke.where = file;
  smoke.file = file;
  const auto text = [&](const char* name) {
    return arguments.find<std::string>(name).value_or("");
  };
  smoke.field = text("field");
  smoke.densityField = text("density-field");
  smoke.model.scale = arguments.find<double>("scale").value_or(smoke.model.scale);
  smoke.model.massExtinction =
      arguments.find<double>("mass-extinction").value_or(smoke.model.massExtinction);
  smoke.model.sootYield = arguments.find<double>("soot-yield").value_or(0);
  if (const auto albedo = arguments.find<Vec3>("albedo"))
    smoke.albedo = albedo->array();
  if ((smoke.albedo < 0).any() || (smoke.albedo > 1).any())
    return fail(ErrorCode::kInvalidArgument, "--albedo: expected numbers from 0 to 1");
  if (arguments.flag("clamp"))
    smoke.negatives = Negatives::kClamp;
  const Words words{text("quantity"), text("unit"), text("material"),
                    text("burning"),  text("mode"), text("C")};
  const auto taken = takeWords(smoke, words);
  if (taken)
    return smoke;
  std::string option = taken.error().about;
  std::ranges::replace(option, '_', '-');
  return fail(ErrorCode::kInvalidArgument, "--{}: {}", option, taken.error().message);
}

bool isSmokeCase(const std::string& path) {
  const std::string extension = extensionOf(path);
  if (extension == ".vtu" || isMeshCase(path))
    return true;
  if (extension != ".pvd")
    return false;
  // A collection of meshes or of images: the first names decide.
  std::ifstream file(path);
  std::string text(64 << 10, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  const auto mesh = text.find(".vtu"), image = text.find(".vti");
  return mesh < image;
}

}  // namespace volute::cli
