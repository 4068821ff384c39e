// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/case_field.hpp"

#include <algorithm>

#include "volute/cli/smoke_arguments.hpp"
#include "volute/optics/visibility.hpp"
#include "volute/scene/scene_smoke.hpp"
#include "volute/visibility/fds_sight.hpp"
#include "volute/visibility/mesh_sight.hpp"

namespace volute::cli {
namespace {

std::string textOf(const Arguments& arguments, const char* name) {
  return arguments.find<std::string>(name).value_or("");
}

/// The library's objection to the value of an option.
tl::unexpected<Error> objection(const char* option, const Error& error) {
  return fail(ErrorCode::kInvalidArgument, "--{}: {}", option, error.message);
}

Result<SightCase> openMesh(const std::string& path, const Arguments& arguments, Context& context) {
  VOLUTE_ASSIGN(const auto smoke, smokeOf(path, arguments));
  if (arguments.given("C") && smoke.model.quantity != SmokeQuantity::kVisibility) {
    return fail(ErrorCode::kInvalidArgument,
                "--C is of a visibility field, and this holds {}; a sign's C stands with the sign",
                nameOf(smoke.model.quantity));
  }
  MeshOptions options;
  options.field = smoke.field;
  options.negatives = smoke.negatives;
  options.maxMemory = context.maxMemory;
  VOLUTE_ASSIGN(auto source, MeshSource::open(path, options));
  std::optional<MeshSource> density;
  if (smoke.model.quantity == SmokeQuantity::kMassFraction) {
    options.field = smoke.densityField;
    VOLUTE_ASSIGN(density, MeshSource::open(path, options));
  }
  VOLUTE_ASSIGN(auto sight,
                MeshSight::open(std::move(source), std::move(density), smoke.model, path));
  std::string words = fmt::format("{}: field '{}' as {} on tetrahedra", path, sight->fieldName(),
                                  nameOf(smoke.model.quantity));
  std::vector<std::string> remarks;
  if (smoke.field.empty() && !sight->otherFields().empty()) {
    remarks.push_back(fmt::format("{}: the field '{}' is read; it also has {} (--field chooses)",
                                  path, sight->fieldName(), sight->otherFields()));
  }
  return SightCase{std::move(sight), std::move(words), std::move(remarks)};
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
  std::vector<Option> options = {
      {.name = "source",
       .kind = ValueKind::kText,
       .value = "NAME",
       .help = "which of an FDS case's files the smoke is read from; else the best"}};
  constexpr std::string_view kOfPictures[] = {"mode",        "albedo",           "fire",
                                              "fire-cutoff", "fire-temperature", "devices",
                                              "slice",       "slice-range"};
  for (const Option& option : smokeOptions()) {
    if (std::ranges::find(kOfPictures, option.name) == std::end(kOfPictures))
      options.push_back(option);
  }
  return options;
}

}  // namespace volute::cli
