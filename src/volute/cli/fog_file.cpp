// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/fog_file.hpp"

#include <filesystem>
#include <limits>
#include <numbers>

#include "volute/cli/json_file.hpp"
#include "volute/cli/suggest.hpp"

namespace volute::cli {
namespace {

using Json = nlohmann::json;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kRightAngle = std::numbers::pi / 2;

/// One object of a JSON file: its members by name, and errors that say where they stand.
class Members {
 public:
  Members(const Json& json, const std::string& file, const std::string& path)
      : json_(json), file_(file), path_(path) {}

  /// An object without other names than these.
  Status check(std::span<const std::string_view> names) const {
    if (!json_.is_object())
      return fail(ErrorCode::kInvalidData, "{}: {}: expected an object", file_, path_);
    for (const auto& [key, value] : json_.items()) {
      if (std::ranges::find(names, key) != names.end())
        continue;
      const auto near = nearest(key, names);
      return fail(ErrorCode::kInvalidData, "{}: {}/{}: this name is unknown{}", file_, path_, key,
                  near.empty() ? "" : fmt::format("; did you mean '{}'?", near));
    }
    return {};
  }

  bool has(const char* key) const { return json_.contains(key); }

  const Json& at(const char* key) const { return json_[key]; }

  std::string where(const char* key) const { return path_ + "/" + key; }

  /// Leaves `value` as it is where the member is missing.
  Status number(const char* key, double& value, double least = -kInfinity,
                double most = kInfinity) const {
    if (!has(key))
      return {};
    VOLUTE_ASSIGN(value, jsonToNumber(json_[key], file_, where(key)));
    if (value >= least && value <= most)
      return {};
    return wrong(key, std::isinf(most) ? fmt::format("at least {}", least)
                                       : fmt::format("{} to {}", least, most));
  }

  Status integer(const char* key, int& value, int least, int most) const {
    if (!has(key))
      return {};
    if (!json_[key].is_number_integer())
      return wrong(key, fmt::format("a whole number from {} to {}", least, most));
    double number = 0;
    VOLUTE_TRY(this->number(key, number, least, most));
    value = static_cast<int>(number);
    return {};
  }

  Status text(const char* key, std::string& value, const char* expected) const {
    if (!has(key) || !json_[key].is_string())
      return fail(ErrorCode::kInvalidData, "{}: {}: expected {}", file_, where(key), expected);
    value = json_[key].get<std::string>();
    return {};
  }

  Status vector(const char* key, Vec3& value) const {
    if (!has(key))
      return {};
    VOLUTE_ASSIGN(value, jsonToVector(json_[key], file_, where(key)));
    return {};
  }

  /// Three numbers within limits.
  Status color(const char* key, Rgb& value, double most) const {
    Vec3 given = value.matrix();
    VOLUTE_TRY(vector(key, given));
    value = given.array();
    if ((value >= 0).all() && (value <= most).all())
      return {};
    return wrong(key, std::isinf(most) ? "numbers of at least 0" : "numbers from 0 to 1");
  }

  /// The library's objection, at a member.
  Status objection(const char* key, const Error& error) const {
    return fail(ErrorCode::kInvalidData, "{}: {}: {}", file_, where(key), error.message);
  }

 private:
  Status wrong(const char* key, std::string_view expected) const {
    return fail(ErrorCode::kInvalidData, "{}: {}: {} is out of range; expected {}", file_,
                where(key), json_[key].dump(), expected);
  }

  const Json& json_;
  const std::string& file_;
  const std::string& path_;
};

std::string besides(const std::string& file, const std::string& name) {
  return (std::filesystem::path(file).parent_path() / name).string();
}

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
  VOLUTE_TRY(members.color("color", fog.options.color, kInfinity));
  VOLUTE_TRY(members.color("albedo", fog.scattering.albedo, 1));
  VOLUTE_TRY(members.number("asymmetry", fog.scattering.asymmetry, -0.999, 0.999));
  if (members.has("path")) {
    std::string path;
    VOLUTE_TRY(members.text("path", path, "\"walk\" or \"polar\""));
    if (path != "walk" && path != "polar")
      return members.objection(
          "path", {ErrorCode::kInvalidData,
                   fmt::format("'{}' is unknown; expected walk or polar", path)});
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

Result<Clock> parseClock(const Json& json, const std::string& file, const std::string& path) {
  if (!json.is_object())
    return fail(ErrorCode::kInvalidData, "{}: {}: expected offset, rate and loop", file, path);
  const Members members(json, file, path);
  Clock clock;
  VOLUTE_TRY(members.number("offset", clock.offset));
  VOLUTE_TRY(members.number("rate", clock.rate));
  if (!(clock.rate > 0))
    return fail(ErrorCode::kInvalidData, "{}: {}/rate: expected more than 0", file, path);
  if (json.contains("loop")) {
    if (!json["loop"].is_boolean())
      return fail(ErrorCode::kInvalidData, "{}: {}/loop: expected true or false", file, path);
    clock.loop = json["loop"].get<bool>();
  }
  return clock;
}

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
  constexpr std::string_view kNames[] = {
      "kind",    "map",   "times", "origin", "cell", "sigma_max", "degree",    "levels", "mu",
      "profile", "color", "wind",  "top",    "time", "albedo",    "asymmetry", "convert",
      "path",    "cell_angle"};
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

Result<std::vector<FogSun>> parseSuns(const Json& json, const std::string& file,
                                      const std::string& path) {
  constexpr std::string_view kNames[] = {"kind", "direction", "radiance"};
  if (!json.is_array())
    return fail(ErrorCode::kInvalidData, "{}: {}: expected a list", file, path);
  std::vector<FogSun> suns;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const std::string at = fmt::format("{}/{}", path, i);
    if (json[i].is_object() && json[i].value("kind", Json()) == "spot") {
      return fail(ErrorCode::kUnsupported,
                  "{}: {}: lights of kind spot are not rendered by this version", file, at);
    }
    const Members members(json[i], file, at);
    VOLUTE_TRY(members.check(kNames));
    if (json[i].value("kind", Json()) != "sun")
      return fail(ErrorCode::kInvalidData, "{}: {}/kind: expected sun or spot", file, at);
    FogSun sun;
    Vec3 direction = Vec3::Zero();
    VOLUTE_TRY(members.vector("direction", direction));
    if (!(direction.z() < 0)) {
      return fail(ErrorCode::kInvalidData,
                  "{}: {}/direction: expected three numbers, the way the light travels, with a "
                  "third below 0",
                  file, at);
    }
    sun.towards = -direction;
    VOLUTE_TRY(members.color("radiance", sun.irradiance, kInfinity));
    suns.push_back(sun);
  }
  return suns;
}

}  // namespace volute::cli
