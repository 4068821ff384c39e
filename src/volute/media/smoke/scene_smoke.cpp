// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/smoke/scene_smoke.hpp"

#include <algorithm>
#include <span>

#include "volute/base/input_file.hpp"
#include "volute/fds/smv_index.hpp"
#include "volute/io/json_members.hpp"
#include "volute/io/mesh_source.hpp"
#include "volute/optics/smoke_potential.hpp"
#include "volute/media/smoke/smoke_words.hpp"
#include "volute/media/volume/volume_input.hpp"

namespace volute {
namespace {

using Json = nlohmann::json;

tl::unexpected<SmokeObjection> object(const char* about, std::string message) {
  return tl::unexpected<SmokeObjection>(SmokeObjection{about, std::move(message)});
}

template <class T>
tl::expected<void, SmokeObjection> take(T& value, Result<T> found, const char* about) {
  if (!found)
    return object(about, found.error().message);
  value = std::move(*found);
  return {};
}

tl::expected<void, SmokeObjection> takeMaterial(SmokeModel& model, const SmokeWords& words) {
  Burning how = Burning::kFlaming;
  if (!words.burning.empty()) {
    if (auto taken = take(how, burning(words.burning), "burning"); !taken)
      return taken;
  }
  if (words.material.empty()) {
    return words.burning.empty() ? tl::expected<void, SmokeObjection>()
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

/// Words about a field that holds something else.
tl::expected<void, SmokeObjection> checkIdleWords(const SmokeDescription& smoke,
                                                  const SmokeWords& words) {
  const SmokeModel& model = smoke.model;
  const SmokeQuantity quantity = model.quantity;
  const std::string_view name = nameOf(quantity);
  const bool products = quantity == SmokeQuantity::kProductsDensity;
  if (!words.unit.empty() && quantity != SmokeQuantity::kSootDensity && !products)
    return object("unit", fmt::format("is for densities, and {} is in {}; leave it out", name,
                                      unitOfField(model)));
  if (words.massExtinction && !holdsMass(quantity))
    return object("mass_extinction",
                  fmt::format("is of soot, and {} is what smoke does to light already; leave it "
                              "out, or say what mass the field holds",
                              name));
  if (model.sootYield != 0 && !products)
    return object("soot_yield",
                  fmt::format("is for products-density, and {}; leave it out",
                              holdsMass(quantity)
                                  ? fmt::format("{} is soot alone", name)
                                  : fmt::format("{} is what smoke does to light already", name)));
  if (model.smokePotential && !products)
    return object("smoke_potential", fmt::format("is for products-density, not for {}", name));
  const char* const potential = words.material.empty() ? "smoke potential" : "material";
  if (model.smokePotential && (model.sootYield != 0 || words.massExtinction))
    return object(model.sootYield != 0 ? "soot_yield" : "mass_extinction",
                  fmt::format("the {} takes its place; leave one of them out", potential));
  if (!smoke.densityField.empty() && quantity != SmokeQuantity::kMassFraction)
    return object("density_field", fmt::format("is for mass-fraction, not for {}", name));
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

tl::expected<void, SmokeObjection> takeWords(SmokeDescription& smoke, const SmokeWords& words) {
  const auto missing = words.quantity.empty();
  const bool saysItself = missing && isSmvPath(smoke.file);
  if (auto taken = saysItself
                       ? tl::expected<void, SmokeObjection>()
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
    smoke.givesC = true;
  }
  if (smoke.model.quantity == SmokeQuantity::kMassFraction && smoke.densityField.empty()) {
    return object("density_field",
                  "is missing; mass-fraction needs the field of the gas's density [kg/m3]");
  }
  if (!saysItself) {
    if (auto idle = checkIdleWords(smoke, words); !idle)
      return idle;
  }
  if (const auto good = smoke.model.check(); !good)
    return object("quantity", good.error().message);
  return {};
}

Result<SmokeDescription> parseSmoke(const Json& json, const std::string& file,
                                    const std::string& path) {
  constexpr std::string_view kNames[] = {
      "kind",    "case",     "field",       "density_field",  "quantity", "unit",
      "scale",   "material", "burning",     "soot_yield",     "C",        "mass_extinction",
      "mode",    "albedo",   "time",        "negatives",      "walls",    "fire",
      "devices", "slice",    "slice_range", "smoke_potential"};
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
  if (members.has("smoke_potential")) {
    smoke.model.smokePotential = 0;
    VOLUTE_TRY(members.number("smoke_potential", *smoke.model.smokePotential));
  }
  VOLUTE_TRY(members.color("albedo", smoke.albedo, 1));
  VOLUTE_TRY(parseNegatives(members, file, smoke));
  VOLUTE_TRY(parseWalls(members, file, smoke));
  for (const char* name : {"fire", "devices", "slice", "slice_range"}) {
    if (members.has(name) && !isSmvPath(smoke.file))
      return fail(ErrorCode::kInvalidData, "{}: {}: is for FDS cases (.smv)", file,
                  members.where(name));
  }
  VOLUTE_ASSIGN(smoke.fds, parseFdsLook(json, file, path));
  if (members.has("smoke_potential") && members.has("material")) {
    return fail(ErrorCode::kInvalidData, "{}: {}: the material has one already; leave one out",
                file, members.where("smoke_potential"));
  }
  if (members.has("time")) {
    VOLUTE_ASSIGN(smoke.clock, parseClock(members.at("time"), file, members.where("time")));
  }
  SmokeWords words;
  const std::pair<const char*, std::string*> texts[] = {
      {"quantity", &words.quantity}, {"unit", &words.unit}, {"material", &words.material},
      {"burning", &words.burning},   {"mode", &words.mode}, {"C", &words.c}};
  for (const auto& [key, text] : texts) VOLUTE_TRY(textOf(members, key, *text));
  words.massExtinction = members.has("mass_extinction");
  if (const auto taken = takeWords(smoke, words); !taken) {
    return fail(ErrorCode::kInvalidData, "{}: {}: {}", file, members.where(taken.error().about),
                taken.error().message);
  }
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
