// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/visibility/case_field.hpp"

#include "volute/cli/visibility/fds_sight.hpp"
#include "volute/cli/visibility/mesh_sight.hpp"
#include "volute/optics/smoke_potential.hpp"
#include "volute/optics/visibility.hpp"

namespace volute::cli {
namespace {

std::string textOf(const Arguments& arguments, const char* name) {
  return arguments.find<std::string>(name).value_or("");
}

/// The library's objection to the value of an option.
tl::unexpected<Error> objection(const char* option, const Error& error) {
  return fail(ErrorCode::kInvalidArgument, "--{}: {}", option, error.message);
}

Status takeMaterial(const Arguments& arguments, SmokeModel& model) {
  const std::string material = textOf(arguments, "material");
  if (material.empty()) {
    if (arguments.given("burning"))
      return fail(ErrorCode::kInvalidArgument, "--burning is for --material");
    return {};
  }
  if (model.quantity != SmokeQuantity::kProductsDensity) {
    return fail(ErrorCode::kInvalidArgument,
                "--material is for --quantity products-density: it says how much of what burns "
                "becomes soot");
  }
  const auto potential = smokePotentialOf(material);
  if (!potential)
    return objection("material", potential.error());
  const std::string how = textOf(arguments, "burning");
  VOLUTE_ASSIGN(const Burning kind, burning(how.empty() ? "flaming" : how));
  model.smokePotential = potential->value(kind);
  return {};
}

Result<SmokeModel> modelOf(const Arguments& arguments) {
  SmokeModel model;
  const std::string quantity = textOf(arguments, "quantity");
  if (quantity.empty()) {
    return fail(ErrorCode::kInvalidArgument,
                "--quantity is missing; say what the field holds: soot-density, products-density, "
                "mass-fraction, extinction, optical-density, optical-density-db or visibility");
  }
  VOLUTE_ASSIGN(model.quantity, smokeQuantity(quantity));
  if (const std::string unit = textOf(arguments, "unit"); !unit.empty()) {
    VOLUTE_ASSIGN(model.unit, densityUnit(unit));
  }
  model.scale = arguments.find<double>("scale").value_or(1);
  model.massExtinction = arguments.find<double>("mass-extinction").value_or(kFdsMassExtinction);
  model.sootYield = arguments.find<double>("soot-yield").value_or(0);
  VOLUTE_TRY(takeMaterial(arguments, model));
  if (const std::string c = textOf(arguments, "C"); !c.empty()) {
    const auto law = visibilityLaw(c);
    if (!law)
      return objection("C", law.error());
    model.c = law->c;
  }
  if (model.quantity == SmokeQuantity::kMassFraction && !arguments.given("density-field")) {
    return fail(ErrorCode::kInvalidArgument,
                "--density-field is missing; mass-fraction needs the gas's density [kg/m3]");
  }
  if (const auto good = model.check(); !good)
    return objection("quantity", good.error());
  return model;
}

Result<SightCase> openMesh(const std::string& path, const Arguments& arguments, Context& context) {
  VOLUTE_ASSIGN(const auto model, modelOf(arguments));
  MeshOptions options;
  options.field = textOf(arguments, "field");
  options.negatives = arguments.flag("clamp") ? Negatives::kClamp : Negatives::kRefuse;
  options.maxMemory = context.maxMemory;
  VOLUTE_ASSIGN(auto source, MeshSource::open(path, options));
  std::optional<MeshSource> density;
  if (model.quantity == SmokeQuantity::kMassFraction) {
    options.field = textOf(arguments, "density-field");
    VOLUTE_ASSIGN(density, MeshSource::open(path, options));
  }
  VOLUTE_ASSIGN(auto sight, MeshSight::open(std::move(source), std::move(density), model, path));
  std::string smoke = fmt::format("{}: field '{}' as {} on tetrahedra", path, sight->fieldName(),
                                  nameOf(model.quantity));
  return SightCase{std::move(sight), std::move(smoke), {}};
}

/// The case's files say what they hold.
Status refuseFieldOptions(const Arguments& arguments) {
  for (const char* option : {"field", "quantity", "unit", "scale", "soot-yield", "material",
                             "burning", "density-field", "clamp"}) {
    if (arguments.given(option)) {
      return fail(ErrorCode::kInvalidArgument,
                  "--{} is for meshes: the files of an FDS case say what they hold; --source "
                  "chooses among them",
                  option);
    }
  }
  return {};
}

Result<SightCase> openFds(const std::string& path, const Arguments& arguments, Context& context) {
  VOLUTE_TRY(refuseFieldOptions(arguments));
  FdsOptions options;
  options.source = textOf(arguments, "source");
  options.massExtinction = arguments.find<double>("mass-extinction").value_or(0);
  options.maxMemory = context.maxMemory;
  if (const std::string c = textOf(arguments, "C"); !c.empty()) {
    const auto law = visibilityLaw(c);
    if (!law)
      return objection("C", law.error());
    options.visibilityFactor = law->c;
  }
  VOLUTE_ASSIGN(auto fds, FdsCase::open(path, options));
  std::string smoke = fmt::format("{}: {} ({})", path, fds.source().name, fds.source().description);
  std::vector<std::string> remarks(fds.remarks().begin(), fds.remarks().end());
  return SightCase{std::make_unique<FdsSight>(std::move(fds)), std::move(smoke),
                   std::move(remarks)};
}

}  // namespace

Result<SightCase> openSightCase(const std::string& path, const Arguments& arguments,
                                Context& context) {
  if (isSmvPath(path))
    return openFds(path, arguments, context);
  if (arguments.given("source"))
    return fail(ErrorCode::kInvalidArgument,
                "--source is for FDS cases (.smv); of a mesh, --field");
  return openMesh(path, arguments, context);
}

std::vector<Option> sightCaseOptions() {
  using enum ValueKind;
  return {
      {.name = "source",
       .kind = kText,
       .value = "NAME",
       .help = "which of an FDS case's files the smoke is read from; else the best"},
      {.name = "field",
       .kind = kText,
       .value = "NAME",
       .help = "the field of a mesh's smoke; else its only scalar"},
      {.name = "quantity",
       .kind = kChoice,
       .value = "NAME",
       .help = "what the field holds",
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
      {.name = "C",
       .kind = kText,
       .value = "C",
       .help = "of a visibility field: jin-reflecting (3), jin-emitting (8), reciprocal-od, or a "
               "number; signs have their own"},
      {.name = "clamp", .help = "take negative values of a field as 0"}};
}

}  // namespace volute::cli
