// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/fog/fog_file.hpp"

#include <nlohmann/json.hpp>
#include <numbers>

#include "volute/base/number_word.hpp"
#include "volute/media/clock_fields.hpp"
#include "volute/media/field_members.hpp"
#include "volute/media/fog/fog_parameters.hpp"

namespace volute {
namespace {

using ProfileKind = FogProfileDescription::Kind;

constexpr std::string_view kProfileKinds[] = {"slab", "exponential", "linear", "layers"};

Result<FogProfile> profileOf(const FogProfileDescription& words) {
  switch (words.kind) {
    case ProfileKind::kSlab:
      return FogProfile::slab(words.bottom, words.top);
    case ProfileKind::kExponential:
      return FogProfile::exponential(words.bottom, words.height);
    case ProfileKind::kLinear: {
      std::vector<FogProfile::Knot> knots;
      for (const auto& knot : words.knots) knots.push_back({knot[0], knot[1]});
      return FogProfile::linear(knots);
    }
    case ProfileKind::kLayers:
      break;
  }
  std::vector<FogProfile::Layer> layers;
  for (const auto& layer : words.layers) layers.push_back({layer[0], layer[1], layer[2]});
  return FogProfile::layers(layers);
}

/// "slab:0,10": KIND:NUMBERS.
Result<FieldValue> profileFrom(std::string_view text) {
  const std::size_t colon = std::min(text.find(':'), text.size());
  const std::string kind(text.substr(0, colon));
  std::vector<double> n;
  for (std::size_t begin = colon; begin < text.size();) {
    const std::size_t end = std::min(text.find(',', begin + 1), text.size());
    double number = 0;
    const std::string_view word = text.substr(begin + 1, end - begin - 1);
    if (!readNumber(word, number))
      return fail(ErrorCode::kInvalidArgument, "'{}': '{}' is not a number", text, word);
    n.push_back(number);
    begin = end;
  }
  const auto rows = [&](std::size_t columns) {
    FieldValue list = FieldValue::array();
    for (std::size_t i = 0; i < n.size(); i += columns)
      list.push_back(std::vector<double>(n.begin() + static_cast<std::ptrdiff_t>(i),
                                         n.begin() + static_cast<std::ptrdiff_t>(i + columns)));
    return list;
  };
  if (n.size() == 2 && (kind == "slab" || kind == "exponential"))
    return FieldValue{{"kind", kind}, {"bottom", n[0]}, {kind == "slab" ? "top" : "height", n[1]}};
  if (kind == "linear" && n.size() >= 4 && n.size() % 2 == 0)
    return FieldValue{{"kind", kind}, {"knots", rows(2)}};
  if (kind == "layers" && n.size() >= 3 && n.size() % 3 == 0)
    return FieldValue{{"kind", kind}, {"layers", rows(3)}};
  return fail(ErrorCode::kInvalidArgument,
              "'{}' is not a profile; expected slab:BOTTOM,TOP, exponential:BOTTOM,HEIGHT, "
              "linear:Z,G,Z,G,.. or layers:BOTTOM,TOP,SHARE,..",
              text);
}

template <ProfileKind... kinds>
bool ofKind(const void* profile, const MediumFacts& /*facts*/) {
  const ProfileKind kind = static_cast<const FogProfileDescription*>(profile)->kind;
  return ((kind == kinds) || ...);
}

double topStep(const void* top, const MediumFacts& /*facts*/) {
  return 0.1 * static_cast<const FogTopDescription*>(top)->placement.cell;
}

const FieldTable& topFields() {
  using enum FieldType;
  using Top = FogTopDescription;
  // clang-format off: a row is read as one
  static const FieldRow kFields[] = {
      {.name = "map", .type = kFile, .access = member<&Top::file>(),
       .help = "a greyscale height map", .required = true},
      {.name = "height", .access = member<&Top::placement, &FogPlacement::sigmaMax>(),
       .help = "height of a white pixel above the fog's origin; there is no fog above the map",
       .unit = "m", .least = 0, .slider = {.label = "height", .least = 0, .most = 100}},
      {.name = "origin", .type = kPoint, .access = member<&Top::placement, &FogPlacement::origin>(),
       .help = "corner of its map, if not that of the fog; its z is ignored", .unit = "m",
       .inherited = true, .slider = {.label = "corner", .step = topStep}},
      {.name = "cell", .access = member<&Top::placement, &FogPlacement::cell>(),
       .help = "side of a pixel of its map, if not that of the fog", .unit = "m", .least = 1e-9,
       .inherited = true,
       .slider = {.label = "cell", .least = 0.01, .most = 10, .logarithmic = true, .room = 2}}};
  // clang-format on
  static const FieldTable kTable = fieldTable<Top>(
      {.name = "top", .sentence = "upper limit of the fog, as a height map", .fields = kFields});
  return kTable;
}

/// Its map lies where the fog's does unless it says otherwise.
void* makeTop(void* object) {
  auto& fog = *static_cast<FogDescription*>(object);
  fog.top.emplace().placement = {fog.placement.origin, fog.placement.cell, 1};
  return &*fog.top;
}

FieldValue conversionOf(const FogDescription& fog) {
  return fog.colour == FogColour::kLuma ? FieldValue("luma") : FieldValue();
}

Status setConversion(FogDescription& fog, const FieldValue& /*luma*/) {
  fog.colour = FogColour::kLuma;
  return {};
}

bool sunsShine(const void* /*fog*/, const MediumFacts& facts) {
  return facts.suns;
}

double windStep(const void* /*fog*/, const MediumFacts& /*facts*/) {
  return 0.05;
}

double fogStep(const void* /*fog*/, const MediumFacts& facts) {
  constexpr double kPixels = 500;  // that draw a fog by its own size
  return (facts.bounds.empty() ? 25 : facts.bounds.size().head<2>().norm()) / kPixels;
}

/// Members of a profile that its kind does not have.
void addIdle(const nlohmann::json& profile, ProfileKind kind,
             std::vector<FogDescription::Idle>& idle) {
  static constexpr std::array<std::array<std::string_view, 2>, 4> kOwn{
      {{"bottom", "top"}, {"bottom", "height"}, {"knots", ""}, {"layers", ""}}};
  const auto at = static_cast<std::size_t>(kind);
  for (const auto& [name, value] : profile.items()) {
    if (name == "kind" || name == kOwn[at][0] || name == kOwn[at][1])
      continue;
    idle.push_back({"profile/" + name,
                    fmt::format("a profile of kind {} has {}{}{}", kProfileKinds[at], kOwn[at][0],
                                kOwn[at][1].empty() ? "" : " and ", kOwn[at][1])});
  }
}

/// What was given and changes nothing.
void addIdle(const nlohmann::json& json, FogDescription& fog) {
  const bool oneLevel = fog.options.levels == 0;
  constexpr const char* kOneLevel = "the map has no coarser levels (levels is 0)";
  if (oneLevel && fog.options.detail.mu != 1)
    fog.idle.push_back({"mu", kOneLevel});
  if (oneLevel && fog.options.detail.cellAngle > 0)
    fog.idle.push_back({"cell_angle", kOneLevel});
  if (!oneLevel && fog.options.detail.finestOnly())
    fog.idle.push_back({"levels", "the finest one serves everywhere (mu is 1, cell_angle 0)"});
  if (!oneLevel && fog.options.detail.mu != 1 && fog.options.detail.cellAngle > 0)
    fog.idle.push_back({"mu", "cell_angle says where levels end"});
  if (fog.border && fog.wind.head<2>().isZero(0) && *fog.border != FogBorder::kZero)
    fog.idle.push_back({"border", "there is no wind"});
  if (fog.wind.head<2>().isZero(0) && fog.wind.z() != 0 && !fog.described && !fog.top)
    fog.idle.push_back({"wind", "it is vertical, and the fog is the same at all heights"});
  if (fog.described)
    addIdle(json["profile"], fog.described->kind, fog.idle);
}

}  // namespace

const FieldTable& fogProfileFields() {
  using enum FieldType;
  using Words = FogProfileDescription;
  // clang-format off: a row is read as one
  static const FieldRow kFields[] = {
      {.name = "kind", .type = kChoice, .access = member<&Words::kind>(),
       .help = "slab: 0 outside; exponential: 1 below its bottom; linear: between knots, 0 "
               "outside; layers: their sum", .choices = kProfileKinds, .required = true},
      {.name = "bottom", .access = member<&Words::bottom>(),
       .help = "bottom of a slab or exponential, above the origin's z", .unit = "m",
       .slider = {.label = "bottom", .least = -20, .most = 20,
                  .shown = ofKind<ProfileKind::kSlab, ProfileKind::kExponential>}},
      {.name = "top", .access = member<&Words::top>(),
       .help = "top of a slab, above the origin's z",
       .unit = "m",
       .slider = {.label = "top", .least = 0, .most = 100, .shown = ofKind<ProfileKind::kSlab>}},
      {.name = "height", .access = member<&Words::height>(),
       .help = "scale height of an exponential", .unit = "m",
       .slider = {.label = "scale height", .least = 1, .most = 200,
                  .shown = ofKind<ProfileKind::kExponential>}},
      {.name = "knots", .type = kRows, .access = member<&Words::knots>(),
       .help = "for linear: heights [m] above the origin's z, and the share of the density there",
       .count = 2},
      {.name = "layers", .type = kRows, .access = member<&Words::layers>(),
       .help = "for layers: bottom and top [m] above the origin's z, and the share of the density",
       .count = 3}};
  // clang-format on
  static const FieldTable kTable = fieldTable<Words>(
      {.name = "profile", .sentence = "height profile of fog", .fields = kFields});
  return kTable;
}

const FieldTable& fogFields() {
  using enum FieldType;
  using Fog = FogDescription;
  static constexpr std::string_view kConversions[] = {"luma"};
  static constexpr std::string_view kPaths[] = {"auto", "walk", "polar"};
  static constexpr std::string_view kRegistrations[] = {"pixel", "coefficient"};
  static constexpr std::string_view kBorders[] = {"zero", "repeat", "clamp"};
  static const FieldAccess kTop = [] {
    FieldAccess access = optionalPart<&Fog::top>();
    access.make = makeTop;
    return access;
  }();
  // clang-format off: a row is read as one
  static const FieldRow kFields[] = {
      {.name = "map", .type = kFile, .access = member<&Fog::maps>(),
       .help = "a greyscale .png (8 or 16 bits) or .exr; a pattern fog_%04d.png; a list of "
       "pictures; or a volume one voxel high. Its bottom row has the smallest y", .several = true,
       .required = true},
      {.name = "times", .type = kNumbers, .access = member<&Fog::times>(),
       .help = "one for each map, interpolated linearly between maps; if not given, the volume's "
               "own, else 25 per second",
       .unit = "s", .count = 0},
      {.name = "convert", .type = kChoice,
       .access = customMember<Fog, conversionOf, setConversion>(),
       .help = "accept a map in colour; luma: Rec. 709 luma of the stored pixel values",
       .choices = kConversions, .option = {"HOW"}},
      {.name = "sigma_max", .access = member<&Fog::placement, &FogPlacement::sigmaMax>(),
       .help = "extinction of a white pixel of the map; linear, without sRGB decoding",
       .unit = "1/m", .least = 0, .option = {"S"},
       .slider = {.label = "densest", .least = 1e-4, .most = 1, .logarithmic = true, .room = 2}},
      {.name = "mu", .access = member<&Fog::options, &FogOptions::detail, &FogDetail::mu>(),
       .help = "level L from the finest ends at mu^(levels - L) of the distance: 1 keeps all "
       "details, 0 none", .least = 0, .most = 1, .option = {"M"}, .slider = {.label = "mu"}},
      {.name = "cell_angle",
       .access = member<&Fog::options, &FogOptions::detail, &FogDetail::cellAngle>(),
       .help = "instead of mu: use a level from the distance at which its cells subtend this "
               "angle; 0: off", .unit = "rad", .least = 0, .most = std::numbers::pi / 2,
       .option = {"A"}},
      {.name = "levels", .type = kInteger, .access = member<&Fog::options, &FogOptions::levels>(),
       .help = "number of times the map is halved", .least = 0, .most = kMaxFogLevels,
       .option = {"J"},
       .slider = {.label = "levels", .most = 6}},
      {.name = "degree", .type = kInteger, .access = member<&Fog::options, &FogOptions::degree>(),
       .help = "degree of the splines: 0 (Haar) is constant in a cell, 1 linear, 2 quadratic, 3 "
               "cubic",
       .least = 0, .most = kMaxSplineDegree, .option = {"D"}, .slider = {.label = "degree"}},
      {.name = "path", .type = kChoice, .access = member<&Fog::path>(),
       .help = "walk: every ray, exactly; polar: through a table for each camera position, "
               "within 1e-4 of the transmittance (by OpenGL 2e-4), if applicable (degree 1 to 3, "
               "slab, linear or layers, no sun, no top, all details), else walk; rays that would "
               "be further off are walked; auto: polar for pictures of maps of 128 pixels and "
               "more, walk in measurements", .choices = kPaths,
       .option = {"HOW"}},
      {.name = "color", .type = kColor, .access = member<&Fog::options, &FogOptions::color>(),
       .help = "linear radiance of infinitely thick fog", .least = 0,
       .option = {.value = "R,G,B", .name = "fog-color", .initial = "0.8,0.85,0.9"},
       .slider = {.label = "colour"}},
      {.name = "albedo", .type = kColor,
       .access = member<&Fog::scattering, &Scattering::albedo>(),
       .help = "scattered share of the extinction; the rest is absorbed",
       .least = 0, .most = 1, .option = {.value = "R,G,B", .beside = "sun"},
       .slider = {.label = "albedo", .shown = sunsShine}},
      {.name = "asymmetry", .access = member<&Fog::scattering, &Scattering::asymmetry>(),
       .help = "mean cosine of the scattering angle of sunlight: above 0 forward, 0.6 to 0.9 for "
               "droplets", .least = -0.999, .most = 0.999,
       .option = {.value = "G", .beside = "sun"},
       .slider = {.label = "asymmetry", .least = -0.9, .most = 0.9, .shown = sunsShine}},
      {.name = "wind", .type = kPoint, .access = member<&Fog::wind>(),
       .help = "wind that moves the fog from 0 s on, along x, y and z", .unit = "m/s", .fewest = 2,
       .option = {"X,Y,Z"}, .slider = {.label = "wind", .step = windStep}},
      {.name = "profile", .type = kObject, .access = optionalPart<&Fog::described>(),
       .help = "height profile above the origin's z; if not given, unbounded",
       .table = &fogProfileFields(),
       .option = {.value = "KIND:NUMBERS", .more = ": slab:BOTTOM,TOP, exponential:BOTTOM,HEIGHT, "
                  "linear:Z,G,Z,G,.. or layers:BOTTOM,TOP,SHARE,..", .parse = profileFrom},
       .slider = {.custom = addProfile}},
      {.name = "origin", .type = kPoint, .access = member<&Fog::placement, &FogPlacement::origin>(),
       .help = "corner of the map with the smallest x and y; heights are relative to its z",
       .unit = "m",
       .option = {"X,Y,Z"}, .slider = {.label = "corner", .section = "placement", .step = fogStep}},
      {.name = "cell", .access = member<&Fog::placement, &FogPlacement::cell>(),
       .help = "side of a pixel of the map", .unit = "m", .least = 1e-9, .option = {"M"},
       .slider = {.label = "cell", .least = 0.1, .most = 10, .logarithmic = true,
                  .section = "placement"}},
      {.name = "registration", .type = kChoice, .access = member<&Fog::registration>(),
       .help = "pixel: a pixel's fog is in the middle of its cell, whatever the degree; "
               "coefficient: it moves by half a cell with each degree, as in volute-scene-1",
       .choices = kRegistrations, .older = "coefficient", .option = {"HOW"}},
      {.name = "border", .type = kChoice, .access = member<&Fog::border>(),
       .help = "what wind brings into the map's rectangle: repeat: what leaves on the other side; "
               "clamp: the pixels at the border; zero: clear air; if not given, repeat in wind",
       .choices = kBorders, .older = "zero", .option = {"WHAT"}},
      {.name = "top", .type = kObject, .access = kTop,
       .help = "upper limit of the fog, as a height map",
       .table = &topFields(), .slider = {.section = "upper end"}},
      clockField<&Fog::clock>()};
  // clang-format on
  static const FieldTable kTable = fieldTable<Fog>({.name = "fog",
                                                    .sentence = "fog from a painted map",
                                                    .fields = kFields,
                                                    .kind = "fog",
                                                    .thing = "a map of fog",
                                                    .things = "maps of fog"});
  return kTable;
}

std::string FogDescription::where() const {
  return origin.options() ? "the fog" : fmt::format("{}: {}", origin.file, origin.path);
}

Error FogDescription::about(Error error, const std::string& member) const {
  const std::string below = member.empty() ? "" : '/' + member;
  if (!origin.options())
    return inFile(std::move(error), origin.file, origin.path + below);
  error.message = fmt::format("{}{}: {}", where(), below, error.message);
  return error;
}

Result<FogDescription> parseFog(const nlohmann::json& json, const FieldOrigin& origin) {
  VOLUTE_ASSIGN(auto fog, readAs<FogDescription>(fogFields(), json, origin));
  fog.origin = origin;
  fog.placed = json.contains("cell") || json.contains("origin");
  addIdle(json, fog);
  if (fog.top && fog.borderInWind() != FogBorder::kZero) {
    return origin.wrong(fogFields().at("border"),
                        "fog with a top ends where its map does; expected zero");
  }
  if (!fog.described)
    return fog;
  const FieldRow& row = fogFields().at("profile");
  const FogProfileDescription& words = *fog.described;
  const char* list = words.kind == ProfileKind::kLinear   ? "knots"
                     : words.kind == ProfileKind::kLayers ? "layers"
                                                          : nullptr;
  if (list && !json["profile"].contains(list)) {
    const FieldRow& missing = fogProfileFields().at(list);
    return origin.within(row).wrong(missing, "is missing; expected " + missing.expected());
  }
  auto profile = profileOf(words);
  if (!profile)
    return origin.wrong(row, profile.error().message);
  fog.profile = std::move(*profile);
  return fog;
}

}  // namespace volute
