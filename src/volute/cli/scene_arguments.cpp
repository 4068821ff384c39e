// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/scene_arguments.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <span>

#include "volute/cli/parse.hpp"
#include "volute/scene/kinds.hpp"

namespace volute::cli {
namespace {

using OrderedJson = nlohmann::ordered_json;

/// An option that stands for a member of a medium's entry, "fire/cutoff" for one within.
struct MemberOption {
  std::string_view option, member;
};

constexpr MemberOption kMembers[] = {{"grid", "field"},
                                     {"field", "field"},
                                     {"source", "source"},
                                     {"bounds", "bounds"},
                                     {"emission", "emission"},
                                     {"extinction", "extinction"},
                                     {"basis", "basis"},
                                     {"quantity", "quantity"},
                                     {"unit", "unit"},
                                     {"scale", "scale"},
                                     {"mass-extinction", "mass_extinction"},
                                     {"soot-yield", "soot_yield"},
                                     {"material", "material"},
                                     {"burning", "burning"},
                                     {"density-field", "density_field"},
                                     {"mode", "mode"},
                                     {"C", "C"},
                                     {"albedo", "albedo"},
                                     {"clamp", "negatives"},
                                     {"fire", "fire/emission"},
                                     {"fire-cutoff", "fire/cutoff"},
                                     {"fire-temperature", "fire/temperature"},
                                     {"devices", "devices"},
                                     {"fds-slice", "slice"},
                                     {"fds-slice-range", "slice_range"}};

OrderedJson vectorJson(const Vec3& v) {
  return OrderedJson::array({v.x(), v.y(), v.z()});
}

/// As a scene says it.
struct JsonOf {
  OrderedJson operator()(bool) const { return true; }
  OrderedJson operator()(const std::string& text) const { return text; }
  OrderedJson operator()(double number) const { return number; }
  OrderedJson operator()(const Vec3& vector) const { return vectorJson(vector); }
  OrderedJson operator()(const Box3& box) const {
    return OrderedJson::array({vectorJson(box.min), vectorJson(box.max)});
  }
  template <class Other>
  OrderedJson operator()(const Other&) const {
    return nullptr;
  }
};

Result<OrderedJson> valueOf(const Arguments& arguments, std::string_view option) {
  if (option == "clamp")
    return "clamp";
  OrderedJson json = std::visit(JsonOf(), *arguments.value(option));
  if (option != "fds-slice-range")
    return json;
  const auto text = json.get<std::string>();
  const std::size_t comma = std::min(text.find(','), text.size() - 1);
  const auto least = parseNumber(text.substr(0, comma)), most = parseNumber(text.substr(comma + 1));
  if (!least || !most || !(*least < *most) || !arguments.given("fds-slice")) {
    return fail(ErrorCode::kInvalidArgument,
                "--fds-slice-range: '{}': expected A,B with A < B, and --fds-slice", text);
  }
  return OrderedJson::array({*least, *most});
}

/// Kinds of which a file alone says too little have no options.
bool has(const MediumKind& kind, std::string_view member) {
  return !kind.assumes() && kind.fields().find(member.substr(0, member.find('/')));
}

/// An option that a kind has nothing to do with.
tl::unexpected<Error> isOfOthers(const MemberOption& option, const MediumKind& kind,
                                 const std::string& path) {
  std::vector<std::string_view> others;
  for (const MediumKind* other : mediumKinds()) {
    if (other->list() == "media" && has(*other, option.member))
      others.push_back(other->plural());
  }
  return fail(ErrorCode::kInvalidArgument, "--{} is for {}; {} is {}", option.option,
              fmt::join(others, " and "), path, kind.singular());
}

}  // namespace

Result<OrderedJson> membersOf(const Arguments& arguments, const MediumKind& kind,
                              const std::string& path) {
  if (arguments.given("field") && arguments.given("grid"))
    return fail(ErrorCode::kInvalidArgument, "--grid is another name of --field; leave one out");
  OrderedJson members = OrderedJson::object();
  for (const MemberOption& option : kMembers) {
    if (!arguments.given(option.option))
      continue;
    if (!has(kind, option.member))
      return isOfOthers(option, kind, path);
    // A source is a case's field by another name.
    const auto member = option.member == "source" ? "field" : option.member;
    VOLUTE_ASSIGN(members[OrderedJson::json_pointer(fmt::format("/{}", member))],
                  valueOf(arguments, option.option));
  }
  return members;
}

Error aboutOptions(Error error, const std::string& path) {
  const std::string begin = path + ": /media/0";
  const std::size_t at = error.message.find(begin);
  if (at == std::string::npos)
    return error;
  std::size_t end = at + begin.size();
  if (error.message[end] != '/') {
    error.message.replace(at, begin.size(), path);
    return error;
  }
  const std::size_t first = ++end;
  while (end < error.message.size() && error.message[end] != ':' && error.message[end] != '[' &&
         error.message[end] != ' ')
    ++end;
  const std::string member = error.message.substr(first, end - first);
  const auto option = std::ranges::find(kMembers, member, &MemberOption::member);
  if (option == std::end(kMembers))
    return error;
  // An entry has the old name of an option, or the new one; the last is what is shown in the help.
  const auto name = option->option == "grid" ? "field" : option->option;
  error.message.replace(at, end - at, fmt::format("--{}", name));
  error.code = ErrorCode::kInvalidArgument;
  return error;
}

Result<Scene> openScene(const std::string& path, const Arguments& arguments, Context& context) {
  registerUsualMedia();
  SceneOptions options;
  options.maxMemory = context.maxMemory;
  options.files.partial = arguments.flag("partial");
  VOLUTE_ASSIGN(options.files.lightCache, lightCache(arguments, context));
  const bool scene = path.ends_with(".json");
  for (const MemberOption& option : kMembers) {
    const bool ofPictures = option.option == "mode" || option.option == "C";
    if (!scene || ofPictures || option.option == "basis" || !arguments.given(option.option))
      continue;
    return fail(ErrorCode::kInvalidArgument, "--{} is for a single file; write it into the scene",
                option.option);
  }
  if (scene && arguments.given("basis"))
    options.overrides["basis"] = arguments.get<std::string>("basis");
  if (!scene) {
    const MediumKind& kind = *mediumKindOf(path, false);
    VOLUTE_ASSIGN(options.members, membersOf(arguments, kind, path));
    // Fire does not absorb by default; an optical depth of nothing would say nothing.
    if (arguments.given("aov") && has(kind, "extinction") && !options.members.contains("extinction"))
      options.members["extinction"] = 1;
  }
  auto opened = Scene::open(path, options, context.progress);
  if (!opened && !scene)
    return tl::unexpected(aboutOptions(std::move(opened.error()), path));
  return opened;
}

Result<OrderedJson> entryOf(const std::string& path, const Arguments& arguments) {
  registerUsualMedia();
  const MediumKind& kind = *mediumKindOf(path, false);
  VOLUTE_ASSIGN(const auto members, membersOf(arguments, kind, path));
  OrderedJson entry = kind.sceneOf(std::filesystem::path(path).filename().string())["media"][0];
  entry.update(members);
  return entry;
}

Result<std::unique_ptr<SightField>> openSight(const std::string& path, const Arguments& arguments,
                                              Context& context) {
  SceneOptions options;
  options.maxMemory = context.maxMemory;
  if (path.ends_with(".json")) {
    VOLUTE_ASSIGN(auto scene, openScene(path, arguments, context));
    return sightOf(std::move(scene), options, context.progress);
  }
  VOLUTE_ASSIGN(const auto entry, entryOf(path, arguments));
  const nlohmann::json plain = entry;
  MediumContext in{context, options.files, SceneLights(), TriangleScene(), path, "/media/0"};
  auto sight = mediumKindOf(path, false)->openSight(plain, in);
  if (!sight)
    return tl::unexpected(aboutOptions(std::move(sight.error()), path));
  return sight;
}

std::vector<Option> sightOptions() {
  std::vector<Option> options = {
      {.name = "source",
       .kind = ValueKind::kText,
       .value = "NAME",
       .help = "which of an FDS case's files the smoke is read from; else the best"}};
  constexpr std::string_view kOfPictures[] = {"mode",        "albedo",           "fire",
                                              "fire-cutoff", "fire-temperature", "devices",
                                              "fds-slice",   "fds-slice-range"};
  for (const Option& option : smokeOptions()) {
    if (std::ranges::find(kOfPictures, option.name) == std::end(kOfPictures))
      options.push_back(option);
  }
  return options;
}

std::vector<Option> volumeOptions() {
  using enum ValueKind;
  return {{.name = "emission",
           .kind = kNumber,
           .value = "S",
           .help = "radiance per metre that one unit of the values emits; else 1"},
          {.name = "extinction",
           .kind = kNumber,
           .value = "S",
           .help = "extinction of one unit of the values [1/m]; 0, with --aov 1",
           .least = 0},
          {.name = "basis",
           .kind = kChoice,
           .value = "NAME",
           .help = "what the values mean between voxel centres, instead of the file's own",
           .choices = {"box", "trilinear"}},
          {.name = "grid",
           .kind = kText,
           .value = "NAME",
           .help = "which grid of a file with several; --field as well"},
          {.name = "bounds",
           .kind = kBounds,
           .value = "X0,Y0,Z0,X1,Y1,Z1",
           .help = "as for compress [m]"}};
}

std::vector<Option> smokeOptions() {
  using enum ValueKind;
  return {
      {.name = "field",
       .kind = kText,
       .value = "NAME",
       .help = "the field of a smoke case, or a file's grid; else its only one"},
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
  const auto limit = arguments.find<Bytes>("cache-size").value_or(Bytes()).count;  // not of all commands
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
