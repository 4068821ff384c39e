// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/fog_arguments.hpp"

#include <numbers>

namespace volute::cli {
namespace {

Result<std::vector<double>> numbersOf(std::string_view text, std::string_view list) {
  std::vector<double> numbers;
  while (!list.empty()) {
    const std::size_t comma = list.find(',');
    const auto number = parseNumber(list.substr(0, comma));
    if (!number)
      return fail(ErrorCode::kInvalidArgument, "'{}': {}", text, number.error().message);
    numbers.push_back(*number);
    list = comma == std::string_view::npos ? std::string_view() : list.substr(comma + 1);
  }
  return numbers;
}

/// A wrong direction or color is wrong usage, as any option out of its limits.
Result<Rgb> lightOf(const Arguments& arguments, const char* name, double most) {
  const Vec3 value = arguments.get<Vec3>(name);
  if ((value.array() >= 0).all() && (value.array() <= most).all())
    return Rgb(value.array());
  return fail(ErrorCode::kInvalidArgument, "--{}: expected three numbers from 0 to {}", name, most);
}

}  // namespace

Result<FogProfile> parseProfile(std::string_view text) {
  const std::size_t colon = std::min(text.find(':'), text.size());
  const std::string_view kind = text.substr(0, colon);
  VOLUTE_ASSIGN(const auto n, numbersOf(text, colon < text.size() ? text.substr(colon + 1) : ""));
  if (kind == "slab" && n.size() == 2)
    return FogProfile::slab(n[0], n[1]);
  if (kind == "exponential" && n.size() == 2)
    return FogProfile::exponential(n[0], n[1]);
  if (kind == "linear" && n.size() >= 4 && n.size() % 2 == 0) {
    std::vector<FogProfile::Knot> knots;
    for (std::size_t i = 0; i < n.size(); i += 2) knots.push_back({n[i], n[i + 1]});
    return FogProfile::linear(knots);
  }
  if (kind == "layers" && n.size() >= 3 && n.size() % 3 == 0) {
    std::vector<FogProfile::Layer> layers;
    for (std::size_t i = 0; i < n.size(); i += 3) layers.push_back({n[i], n[i + 1], n[i + 2]});
    return FogProfile::layers(layers);
  }
  return fail(ErrorCode::kInvalidArgument,
              "'{}' is no profile; expected slab:BOTTOM,TOP, exponential:BOTTOM,HEIGHT, "
              "linear:Z,G,Z,G,.. or layers:BOTTOM,TOP,SHARE,..",
              text);
}

Result<FogDescription> fogOf(const Arguments& arguments, const std::string& map) {
  FogDescription fog;
  fog.where = "the fog";
  fog.maps = {map};
  fog.placement = {arguments.get<Vec3>("origin"), arguments.get<double>("cell"),
                   arguments.get<double>("sigma-max")};
  fog.options.degree = arguments.get<int>("degree");
  fog.options.levels = arguments.get<int>("levels");
  fog.options.detail.mu = arguments.get<double>("mu");
  fog.options.detail.cellAngle = arguments.get<double>("cell-angle");
  fog.polar = arguments.get<std::string>("path") == "polar";
  VOLUTE_ASSIGN(fog.options.color, lightOf(arguments, "fog-color", 1e6));
  VOLUTE_ASSIGN(fog.scattering.albedo, lightOf(arguments, "albedo", 1));
  fog.scattering.asymmetry = arguments.get<double>("asymmetry");
  fog.wind = arguments.get<Vec3>("wind");
  if (arguments.given("convert"))
    fog.colour = FogColour::kLuma;
  if (const auto profile = arguments.find<std::string>("profile")) {
    auto parsed = parseProfile(*profile);
    if (!parsed)
      return fail(ErrorCode::kInvalidArgument, "--profile: {}", parsed.error().message);
    fog.profile = std::move(*parsed);
  }
  if (const auto sun = arguments.find<Vec3>("sun"); sun && !(sun->z() < 0)) {
    return fail(ErrorCode::kInvalidArgument,
                "--sun: expected the way its light travels, with a third number below 0");
  }
  VOLUTE_TRY(lightOf(arguments, "sun-radiance", 1e6));
  return fog;
}

std::vector<FogSun> sunsOf(const Arguments& arguments) {
  const auto direction = arguments.find<Vec3>("sun");
  if (!direction)
    return {};
  return {{-*direction, Rgb(arguments.get<Vec3>("sun-radiance").array())}};
}

std::vector<Option> fogOptionTable() {
  using enum ValueKind;
  return {
      {.name = "degree",
       .kind = kInteger,
       .value = "D",
       .help = "of the splines: 0 (Haar) is constant in a cell, 1 linear, 2 quadratic, 3 cubic",
       .initial = "1",
       .least = 0,
       .most = kMostSplineDegree},
      {.name = "levels",
       .kind = kInteger,
       .value = "J",
       .help = "how often the map is halved",
       .initial = "0",
       .least = 0,
       .most = kMostFogLevels},
      {.name = "mu",
       .kind = kNumber,
       .value = "M",
       .help = "level L from the finest ends at M^(J - L) of the distance: 1 keeps all details, 0 "
               "none",
       .initial = "1",
       .least = 0,
       .most = 1},
      {.name = "cell-angle",
       .kind = kNumber,
       .value = "A",
       .help = "instead of --mu: a level is used from where its cells are seen under this angle "
               "[rad]; 0: off",
       .initial = "0",
       .least = 0,
       .most = std::numbers::pi / 2},
      {.name = "path",
       .kind = kChoice,
       .value = "HOW",
       .help = "walk: every ray, exactly; polar: by a table for each picture's eye, within 1/512 of "
               "transmittance, where it serves (degree 1 to 3, slab, linear or layers, no sun, all "
               "details), else walk",
       .initial = "walk",
       .choices = {"walk", "polar"}},
      {.name = "profile",
       .kind = kText,
       .value = "KIND:NUMBERS",
       .help = "how it thins with height [m above the origin]: slab:BOTTOM,TOP, "
               "exponential:BOTTOM,HEIGHT, linear:Z,G,.. or layers:BOTTOM,TOP,SHARE,..; else it "
               "has no end"},
      {.name = "origin",
       .kind = kVector,
       .value = "X,Y,Z",
       .help = "the map's corner of the smallest x and y [m]",
       .initial = "0,0,0"},
      {.name = "cell",
       .kind = kNumber,
       .value = "M",
       .help = "side of a pixel of the map [m]",
       .initial = "1",
       .positive = true},
      {.name = "sigma-max",
       .kind = kNumber,
       .value = "S",
       .help = "extinction of a white pixel [1/m]",
       .initial = "0.05",
       .least = 0},
      {.name = "convert",
       .kind = kChoice,
       .value = "HOW",
       .help = "allow a map in colour: luma is Rec. 709's of the pixel values as they stand",
       .choices = {"luma"}},
      {.name = "fog-color",
       .kind = kVector,
       .value = "R,G,B",
       .help = "linear radiance of infinitely thick fog",
       .initial = "0.8,0.85,0.9"},
      {.name = "wind",
       .kind = kVector,
       .value = "X,Y,Z",
       .help = "moves the map [m/s]",
       .initial = "0,0,0"},
      {.name = "sun",
       .kind = kVector,
       .value = "X,Y,Z",
       .help = "the way a sun's light travels; the fog scatters it once and shadows itself"},
      {.name = "sun-radiance",
       .kind = kVector,
       .value = "R,G,B",
       .help = "what the sun sends to a surface that faces it",
       .initial = "1,1,1"},
      {.name = "albedo",
       .kind = kVector,
       .value = "R,G,B",
       .help = "share of the sun's light that is scattered, not absorbed",
       .initial = "1,1,1"},
      {.name = "asymmetry",
       .kind = kNumber,
       .value = "G",
       .help = "of the phase function; 0.6 to 0.9 for droplets",
       .initial = "0",
       .least = -0.999,
       .most = 0.999}};
}

}  // namespace volute::cli
