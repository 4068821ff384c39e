// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/smoke_arguments.hpp"

#include <algorithm>

namespace volute::cli {

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
  const SmokeWords words{text("quantity"), text("unit"), text("material"),
                         text("burning"),  text("mode"), text("C")};
  const auto taken = takeWords(smoke, words);
  if (taken)
    return smoke;
  std::string option = taken.error().about;
  std::ranges::replace(option, '_', '-');
  return fail(ErrorCode::kInvalidArgument, "--{}: {}", option, taken.error().message);
}

}  // namespace volute::cli
