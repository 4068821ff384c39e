// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/fog/fog_file.hpp"

#include <numbers>

#include "volute/io/json_members.hpp"
#include "volute/io/json_values.hpp"

namespace volute {
namespace {

using Json = nlohmann::json;
constexpr double kRightAngle = std::numbers::pi / 2;

/// Rows of so many numbers each.
Result<std::vector<std::vector<double>>> tableOf(const Json& json, std::size_t columns,
                                                 const std::string& file, const std::string& path) {
  if (!json.is_array())
    return fail(ErrorCode::kInvalidData, "{}: {}: expected a list", file, path);
  std::vector<std::vector<double>> rows;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const std::string at = fmt::format("{}[{}]", path, i);
    if (!json[i].is_array() || json[i].size() != columns)
      return fail(ErrorCode::kInvalidData, "{}: {}: expected {} numbers", file, at, columns);
    rows.emplace_back();
    for (std::size_t k = 0; k < columns; ++k) {
      VOLUTE_ASSIGN(const double value, jsonToNumber(json[i][k], file, at));
      rows.back().push_back(value);
    }
  }
  return rows;
}

/// "map": a name or a list of names; "times" goes with it.
Status readMaps(const Members& members, const std::string& file, FogDescription& fog) {
  const Json names = members.has("map") ? members.at("map") : Json();
  const Json list = names.is_string() ? Json::array({names}) : names;
  const bool good = list.is_array() && !list.empty() &&
                    std::ranges::all_of(list, [](const Json& name) { return name.is_string(); });
  if (!good) {
    return fail(ErrorCode::kInvalidData,
                "{}: {}: expected the name of a greyscale picture, a pattern, a volume, or a list "
                "of pictures",
                file, members.where("map"));
  }
  for (const Json& name : list) fog.maps.push_back(besides(file, name.get<std::string>()));
  if (!members.has("times"))
    return {};
  const Json& times = members.at("times");
  if (!times.is_array())
    return fail(ErrorCode::kInvalidData, "{}: {}: expected a list of seconds", file,
                members.where("times"));
  for (std::size_t i = 0; i < times.size(); ++i) {
    VOLUTE_ASSIGN(const double time, jsonToNumber(times[i], file, members.where("times")));
    fog.times.push_back(time);
  }
  return {};
}

Status readTop(const Json& json, const std::string& file, const std::string& path,
               FogDescription& fog) {
  constexpr std::string_view kNames[] = {"map", "origin", "cell", "height"};
  const Members members(json, file, path);
  VOLUTE_TRY(members.check(kNames));
  FogTopDescription top;
  VOLUTE_TRY(members.text("map", top.file, "the name of a greyscale picture"));
  top.file = besides(file, top.file);
  top.placement = {fog.placement.origin, fog.placement.cell, 1};
  VOLUTE_TRY(members.vector("origin", top.placement.origin));
  VOLUTE_TRY(members.number("cell", top.placement.cell, 1e-9));
  VOLUTE_TRY(members.number("height", top.placement.sigmaMax, 0));
  fog.top = top;
  return {};
}

Status readWind(const Members& members, const std::string& file, FogDescription& fog) {
  if (!members.has("wind"))
    return {};
  const Json& wind = members.at("wind");
  if (!wind.is_array() || wind.size() < 2 || wind.size() > 3) {
    return fail(ErrorCode::kInvalidData, "{}: {}: expected two or three numbers [m/s]", file,
                members.where("wind"));
  }
  for (std::size_t axis = 0; axis < wind.size(); ++axis) {
    VOLUTE_ASSIGN(fog.wind[static_cast<int>(axis)],
                  jsonToNumber(wind[axis], file, members.where("wind")));
  }
  return {};
}

Status readMeaning(const Members& members, FogDescription& fog) {
  VOLUTE_TRY(members.vector("origin", fog.placement.origin));
  VOLUTE_TRY(members.number("cell", fog.placement.cell, 1e-9));
  VOLUTE_TRY(members.number("sigma_max", fog.placement.sigmaMax, 0));
  VOLUTE_TRY(members.integer("degree", fog.options.degree, 0, kMostSplineDegree));
  VOLUTE_TRY(members.integer("levels", fog.options.levels, 0, kMostFogLevels));
  VOLUTE_TRY(members.number("mu", fog.options.detail.mu, 0, 1));
  VOLUTE_TRY(members.number("cell_angle", fog.options.detail.cellAngle, 0, kRightAngle));
  VOLUTE_TRY(members.color("color", fog.options.color, kUnlimited));
  VOLUTE_TRY(members.color("albedo", fog.scattering.albedo, 1));
  VOLUTE_TRY(members.number("asymmetry", fog.scattering.asymmetry, -0.999, 0.999));
  if (members.has("path")) {
    std::string path;
    VOLUTE_TRY(members.text("path", path, "\"walk\" or \"polar\""));
    if (path != "walk" && path != "polar")
      return members.objection(
          "path",
          {ErrorCode::kInvalidData, fmt::format("'{}' is unknown; expected walk or polar", path)});
    fog.polar = path == "polar";
  }
  if (!members.has("convert"))
    return {};
  std::string convert;
  VOLUTE_TRY(members.text("convert", convert, "\"luma\""));
  if (convert != "luma")
    return members.objection("convert", {ErrorCode::kInvalidData,
                                         fmt::format("'{}' is unknown; expected luma", convert)});
  fog.colour = FogColour::kLuma;
  return {};
}

}  // namespace

Result<FogProfile> parseFogProfile(const Json& json, const std::string& file,
                                   const std::string& path) {
  constexpr std::string_view kNames[] = {"kind", "bottom", "top", "height", "knots", "layers"};
  const Members members(json, file, path);
  VOLUTE_TRY(members.check(kNames));
  std::string kind;
  VOLUTE_TRY(members.text("kind", kind, "slab, exponential, linear or layers"));
  const auto at = [&](Result<FogProfile> made) -> Result<FogProfile> {
    if (made)
      return made;
    return fail(ErrorCode::kInvalidData, "{}: {}: {}", file, path, made.error().message);
  };
  double bottom = 0, top = 10, height = 20;
  VOLUTE_TRY(members.number("bottom", bottom));
  VOLUTE_TRY(members.number("top", top));
  VOLUTE_TRY(members.number("height", height));
  if (kind == "slab")
    return at(FogProfile::slab(bottom, top));
  if (kind == "exponential")
    return at(FogProfile::exponential(bottom, height));
  if (kind == "linear") {
    VOLUTE_ASSIGN(const auto rows, tableOf(members.has("knots") ? json["knots"] : Json(), 2, file,
                                           members.where("knots")));
    std::vector<FogProfile::Knot> knots;
    for (const auto& row : rows) knots.push_back({row[0], row[1]});
    return at(FogProfile::linear(knots));
  }
  if (kind == "layers") {
    VOLUTE_ASSIGN(const auto rows, tableOf(members.has("layers") ? json["layers"] : Json(), 3, file,
                                           members.where("layers")));
    std::vector<FogProfile::Layer> layers;
    for (const auto& row : rows) layers.push_back({row[0], row[1], row[2]});
    return at(FogProfile::layers(layers));
  }
  return fail(ErrorCode::kInvalidData,
              "{}: {}/kind: '{}' is unknown; expected slab, exponential, linear or layers", file,
              path, kind);
}

Result<FogDescription> parseFog(const Json& json, const std::string& file,
                                const std::string& path) {
  constexpr std::string_view kNames[] = {"kind",      "map",     "times",  "origin",    "cell",
                                         "sigma_max", "degree",  "levels", "mu",        "profile",
                                         "color",     "wind",    "top",    "time",      "albedo",
                                         "asymmetry", "convert", "path",   "cell_angle"};
  const Members members(json, file, path);
  VOLUTE_TRY(members.check(kNames));
  FogDescription fog;
  fog.where = file + ": " + path;
  VOLUTE_TRY(readMaps(members, file, fog));
  VOLUTE_TRY(readMeaning(members, fog));
  VOLUTE_TRY(readWind(members, file, fog));
  if (members.has("profile")) {
    VOLUTE_ASSIGN(fog.profile, parseFogProfile(json["profile"], file, members.where("profile")));
  }
  if (members.has("time")) {
    VOLUTE_ASSIGN(fog.clock, parseClock(json["time"], file, members.where("time")));
  }
  if (members.has("top"))
    VOLUTE_TRY(readTop(json["top"], file, members.where("top"), fog));
  return fog;
}

}  // namespace volute
