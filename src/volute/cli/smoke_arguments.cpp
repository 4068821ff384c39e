// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/smoke_arguments.hpp"

#include <algorithm>

#include "volute/cli/parse.hpp"
#include "volute/fds/smv_index.hpp"

namespace volute::cli {

std::vector<Option> smokeOptions() {
  using enum ValueKind;
  return {
      {.name = "field",
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
      {.name = "fire",
       .kind = kNumber,
       .value = "S",
       .help = "luminance per metre of an FDS fire that releases 1 MW/m3; 0 shows none; else 20",
       .least = 0},
      {.name = "fire-cutoff",
       .kind = kNumber,
       .value = "Q",
       .help = "where a fire releases less there is no flame [kW/m3]; else as the case says",
       .least = 0},
      {.name = "fire-temperature",
       .kind = kNumber,
       .value = "T",
       .help = "of the black body whose colour flames have [K]; else 1500",
       .least = 500,
       .most = 20000},
      {.name = "devices", .help = "mark the devices of an FDS case"},
      {.name = "fds-slice",
       .kind = kText,
       .value = "QUANTITY",
       .help = "also show the FDS case's 2D slices of this quantity (TEMPERATURE)"},
      {.name = "fds-slice-range",
       .kind = kText,
       .value = "A,B",
       .help = "of its colours; else all its values"},
      {.name = "clamp", .help = "take negative values of a smoke field as 0"}};
}

namespace {

/// What only FDS cases have.
Status takeLook(const Arguments& arguments, SmokeDescription& smoke) {
  for (const char* name :
       {"fire", "fire-cutoff", "fire-temperature", "devices", "fds-slice", "fds-slice-range"}) {
    if (arguments.given(name) && !isSmvPath(smoke.file))
      return fail(ErrorCode::kInvalidArgument, "--{} is for FDS cases (.smv)", name);
  }
  FdsLook& look = smoke.fds;
  look.flame.emission = arguments.find<double>("fire").value_or(look.flame.emission);
  look.flame.temperature =
      arguments.find<double>("fire-temperature").value_or(look.flame.temperature);
  look.cutoff = arguments.find<double>("fire-cutoff");
  look.devices = arguments.flag("devices");
  look.slice = arguments.find<std::string>("fds-slice").value_or("");
  const auto range = arguments.find<std::string>("fds-slice-range");
  if (!range)
    return {};
  const std::size_t comma = std::min(range->find(','), range->size() - 1);
  const auto least = parseNumber(range->substr(0, comma));
  const auto most = parseNumber(range->substr(comma + 1));
  if (!least || !most || !(*least < *most) || look.slice.empty()) {
    return fail(ErrorCode::kInvalidArgument,
                "--fds-slice-range: '{}': expected A,B with A < B, and --fds-slice", *range);
  }
  look.sliceRange = std::array{*least, *most};
  return {};
}

}  // namespace

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
  VOLUTE_TRY(takeLook(arguments, smoke));
  const SmokeWords words{text("quantity"),
                         text("unit"),
                         text("material"),
                         text("burning"),
                         text("mode"),
                         text("C"),
                         arguments.given("mass-extinction")};
  const auto taken = takeWords(smoke, words);
  if (taken)
    return smoke;
  std::string option = taken.error().about;
  std::ranges::replace(option, '_', '-');
  return fail(ErrorCode::kInvalidArgument, "--{}: {}", option, taken.error().message);
}

std::vector<Option> lightCacheOptions() {
  using enum ValueKind;
  return {{.name = "cache",
           .kind = kFile,
           .value = "DIR",
           .help = "where the light of lamps in smoke is kept, or none; else volute/light in the "
                   "user's cache folder"},
          {.name = "cache-size",
           .kind = kBytes,
           .value = "BYTES",
           .help = "what it may take there",
           .initial = "1G"}};
}

Result<std::optional<LightCache>> lightCache(const Arguments& arguments, Context& context) {
  const auto limit = arguments.get<Bytes>("cache-size").count;
  const auto folder = arguments.find<std::string>("cache");
  if (limit == 0 || folder == "none")
    return std::nullopt;
  if (folder) {
    VOLUTE_ASSIGN(auto cache, LightCache::open(*folder, limit));
    return cache;
  }
  if (LightCache::usualFolder().empty())
    return std::nullopt;
  auto cache = LightCache::open(LightCache::usualFolder(), limit);
  if (cache)
    return std::optional(std::move(*cache));
  context.progress.remark("light is not kept: " + cache.error().message);
  return std::nullopt;
}

}  // namespace volute::cli
