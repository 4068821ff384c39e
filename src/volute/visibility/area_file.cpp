// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/area_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "volute/base/plain_number.hpp"
#include "volute/io/json_file.hpp"
#include "volute/io/json_members.hpp"
#include "volute/io/json_values.hpp"

namespace volute {
namespace {

constexpr double kTouch = 0.01;  // [m], by which drawn lines may miss each other

double cross(const Vec2& a, const Vec2& b) {
  return a.x() * b.y() - a.y() * b.x();
}

double distanceTo(const Vec2& point, const Vec2& a, const Vec2& b) {
  const Vec2 along = b - a;
  const double length = along.squaredNorm();
  const double share = length > 0 ? std::clamp((point - a).dot(along) / length, 0.0, 1.0) : 0;
  return (point - a - share * along).norm();
}

bool isInside(std::span<const Vec2> polygon, const Vec2& point) {
  bool inside = false;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const Vec2 &a = polygon[i], &b = polygon[j];
    if ((a.y() > point.y()) != (b.y() > point.y()) &&
        point.x() < a.x() + (point.y() - a.y()) * (b.x() - a.x()) / (b.y() - a.y()))
      inside = !inside;
  }
  return inside;
}

bool isDeepInside(std::span<const Vec2> polygon, const Vec2& point) {
  if (!isInside(polygon, point))
    return false;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    if (distanceTo(point, polygon[i], polygon[j]) <= kTouch)
      return false;
  }
  return true;
}

/// Where two lines cross, both farther than kTouch from the ends of either.
std::optional<Vec2> crossing(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  const double turn = cross(b - a, d - c);
  if (turn == 0)
    return std::nullopt;
  const double s = cross(c - a, d - c) / turn, t = cross(c - a, b - a) / turn;
  if (!(s > 0 && s < 1 && t > 0 && t < 1))
    return std::nullopt;
  const Vec2 at = a + s * (b - a);
  for (const Vec2& end : {a, b, c, d}) {
    if ((at - end).norm() <= kTouch)
      return std::nullopt;
  }
  return at;
}

std::string placeText(const Vec2& place) {
  return fmt::format("x = {}, y = {} m", plainNumber(place.x(), 4), plainNumber(place.y(), 4));
}

/// Twice the signed area.
double turnOf(std::span<const Vec2> polygon) {
  double sum = 0;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++)
    sum += cross(polygon[j], polygon[i]);
  return sum;
}

/// What is wrong with a polygon; empty: nothing.
std::string faultOf(std::span<const Vec2> polygon) {
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    for (std::size_t j = i + 1; j < polygon.size(); ++j) {
      const auto at = crossing(polygon[i], polygon[(i + 1) % polygon.size()], polygon[j],
                               polygon[(j + 1) % polygon.size()]);
      if (at)
        return fmt::format("crosses itself at {}", placeText(*at));
    }
  }
  return std::abs(turnOf(polygon)) < 2 * kTouch * kTouch ? "has no area" : "";
}

constexpr std::size_t kMaxAreas = 1000;
constexpr std::size_t kMaxPoints = 10'000;  // of a polygon: it is compared with itself

struct Storey {
  std::string name;
  double low = 0, high = 0;
};

/// An object of the file.
class AreaReader {
 public:
  AreaReader(const nlohmann::json& json, const std::string& file, std::string path)
      : json_(json), file_(file), path_(std::move(path)) {}

  tl::unexpected<Error> wrong(std::string_view key, std::string_view message) const {
    return fail(ErrorCode::kInvalidData, "{}: {}{}{}: {}", file_, path_, key.empty() ? "" : "/",
                key, message);
  }

  Status checkNames(std::span<const std::string_view> names) const {
    return checkMembers(json_, names, file_, path_);
  }

  bool has(const char* key) const { return json_.contains(key); }

  Result<std::string> name() const {
    if (!has("name") || !json_["name"].is_string() || json_["name"].get<std::string>().empty())
      return wrong("name", "expected a text");
    return json_["name"].get<std::string>();
  }

  Result<double> number(const char* key, double initial, double least) const {
    if (!has(key))
      return initial;
    VOLUTE_ASSIGN(const double value, jsonToNumber(json_[key], file_, where(key)));
    if (!(value >= least))
      return wrong(key, fmt::format("{:g}; expected {:g} or more", value, least));
    return value;
  }

  Result<Storey> storey() const {
    constexpr std::array<std::string_view, 2> kNames{"name", "z"};
    VOLUTE_TRY(checkNames(kNames));
    Storey storey;
    VOLUTE_ASSIGN(storey.name, name());
    if (!has("z") || !json_["z"].is_array() || json_["z"].size() != 2)
      return wrong("z", "expected [floor, ceiling] in metres");
    VOLUTE_ASSIGN(storey.low, jsonToNumber(json_["z"][0], file_, where("z/0")));
    VOLUTE_ASSIGN(storey.high, jsonToNumber(json_["z"][1], file_, where("z/1")));
    if (!(storey.low < storey.high))
      return wrong("z", fmt::format("{} to {} m; expected the floor below the ceiling",
                                    plainNumber(storey.low), plainNumber(storey.high)));
    return storey;
  }

  Result<std::vector<Vec2>> points(const char* key, std::size_t least) const {
    if (!has(key) || !json_[key].is_array() || json_[key].size() < least ||
        json_[key].size() > kMaxPoints) {
      return wrong(key, fmt::format("expected a list of {} to {} points [x, y] in metres", least,
                                    kMaxPoints));
    }
    std::vector<Vec2> points;
    for (std::size_t i = 0; i < json_[key].size(); ++i) {
      const nlohmann::json& point = json_[key][i];
      const std::string path = fmt::format("{}/{}", where(key), i);
      if (!point.is_array() || point.size() != 2)
        return fail(ErrorCode::kInvalidData, "{}: {}: expected [x, y] in metres", file_, path);
      VOLUTE_ASSIGN(const double x, jsonToNumber(point[0], file_, path + "/0"));
      VOLUTE_ASSIGN(const double y, jsonToNumber(point[1], file_, path + "/1"));
      points.emplace_back(x, y);
    }
    return points;
  }

  Result<std::vector<Vec2>> polygon() const {
    VOLUTE_ASSIGN(auto polygon, points("polygon", 3));
    if (polygon.front() == polygon.back())
      polygon.pop_back();
    if (const std::string fault = faultOf(polygon); !fault.empty())
      return wrong("polygon", fault);
    return polygon;
  }

  Status readStorey(std::span<const Storey> storeys, NamedArea& area) const {
    if (!has("storey"))
      return {};
    if (!json_["storey"].is_string())
      return wrong("storey", "expected the name of a storey");
    area.storey = json_["storey"].get<std::string>();
    const auto found = std::ranges::find(storeys, area.storey, &Storey::name);
    if (found == storeys.end()) {
      std::vector<std::string_view> names;
      for (const Storey& one : storeys) names.push_back(one.name);
      return wrong("storey", fmt::format("there is no storey '{}' in /storeys{}{}", area.storey,
                                         names.empty() ? "" : ", but ", fmt::join(names, ", ")));
    }
    area.low = found->low;
    area.high = found->high;
    return {};
  }

  Result<NamedArea> area(NamedArea::Kind kind, std::span<const Storey> storeys) const {
    using Names = std::vector<std::string_view>;
    VOLUTE_TRY(checkNames(kind == NamedArea::Kind::kArea
                              ? Names{"name", "storey", "polygon", "people", "rset"}
                          : kind == NamedArea::Kind::kExit
                              ? Names{"name", "storey", "line", "radius", "rset"}
                              : Names{"name", "storey", "line", "width", "areas", "rset"}));
    NamedArea area;
    area.kind = kind;
    VOLUTE_ASSIGN(area.name, name());
    VOLUTE_TRY(readStorey(storeys, area));
    if (kind == NamedArea::Kind::kArea) {
      VOLUTE_ASSIGN(area.outline, polygon());
    } else if (kind == NamedArea::Kind::kExit) {
      VOLUTE_ASSIGN(area.outline, points("line", 1));
      VOLUTE_ASSIGN(area.reach, number("radius", 1, 1e-3));
    } else if (has("areas")) {
      if (has("line"))
        return wrong("line", "a route has a line or areas, not both");
      if (has("width"))
        return wrong("width", "has no effect on a route of areas; leave it out");
      if (!json_["areas"].is_array() || json_["areas"].empty())
        return wrong("areas", "expected a list of names of areas and exits");
      for (const nlohmann::json& one : json_["areas"]) {
        if (!one.is_string())
          return wrong("areas", "expected a list of names of areas and exits");
        area.members.push_back(one.get<std::string>());
      }
    } else {
      VOLUTE_ASSIGN(area.outline, points("line", 2));
      VOLUTE_ASSIGN(const double width, number("width", 1.2, 2e-3));
      area.reach = width / 2;
    }
    if (has("people")) {
      if (!json_["people"].is_boolean())
        return wrong("people", "expected true or false");
      area.people = json_["people"].get<bool>();
    }
    if (has("rset")) {
      VOLUTE_ASSIGN(const double seconds, number("rset", 0, 0));
      area.rset = seconds;
    }
    return area;
  }

 private:
  std::string where(std::string_view key) const { return fmt::format("{}/{}", path_, key); }

  const nlohmann::json& json_;
  const std::string& file_;
  std::string path_;
};

bool share(const NamedArea& one, const NamedArea& other) {
  return one.low < other.high && other.low < one.high;
}

}  // namespace

Status checkTogether(std::span<const NamedArea> areas, std::span<const std::string> from) {
  for (std::size_t i = 0; i < areas.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (areas[i].name == areas[j].name) {
        return fail(ErrorCode::kInvalidData, "{}: '{}' is the name of {} as well", from[i],
                    areas[i].name, from[j]);
      }
      const bool polygons =
          areas[i].kind == NamedArea::Kind::kArea && areas[j].kind == NamedArea::Kind::kArea;
      if (!polygons || !share(areas[i], areas[j]))
        continue;
      if (const auto at = overlap(areas[i].outline, areas[j].outline)) {
        return fail(ErrorCode::kInvalidData,
                    "{}: area '{}' overlaps area '{}' ({}), at {}; expected areas beside each "
                    "other, or on different storeys",
                    from[i], areas[i].name, areas[j].name, from[j], placeText(*at));
      }
    }
    for (const std::string& member : areas[i].members) {
      const auto* found = std::ranges::find(areas, member, &NamedArea::name).base();
      if (found == areas.data() + areas.size() || found->kind == NamedArea::Kind::kRoute) {
        return fail(ErrorCode::kInvalidData, "{}: there is no area or exit '{}'", from[i], member);
      }
    }
  }
  return {};
}

bool NamedArea::contains(const Vec2& point) const {
  if (kind == Kind::kArea)
    return isInside(outline, point);
  for (std::size_t i = 0; i < outline.size(); ++i) {
    if (distanceTo(point, outline[i], outline[std::min(i + 1, outline.size() - 1)]) <= reach)
      return true;
  }
  return false;
}

std::optional<Vec2> overlap(std::span<const Vec2> one, std::span<const Vec2> other) {
  constexpr int kSamples = 100;
  const auto crossed = [&]() -> std::optional<Vec2> {
    for (std::size_t i = 0; i < one.size(); ++i) {
      for (std::size_t j = 0; j < other.size(); ++j) {
        const Vec2 &a = one[i], &b = one[(i + 1) % one.size()];
        const Vec2 &c = other[j], &d = other[(j + 1) % other.size()];
        const auto at = crossing(a, b, c, d);
        // Lines that touch along each other cross at a small angle.
        const auto beyond = [&](const Vec2& p, const Vec2& q, const Vec2& r, const Vec2& s) {
          return std::min(distanceTo(p, r, s), distanceTo(q, r, s)) > kTouch;
        };
        if (at && beyond(a, b, c, d) && beyond(c, d, a, b))
          return at;
      }
    }
    return std::nullopt;
  }();
  if (crossed)
    return crossed;
  for (const auto& [inner, outer] : {std::pair(one, other), std::pair(other, one)}) {
    for (const Vec2& point : inner) {
      if (isDeepInside(outer, point))
        return point;
    }
  }
  // Polygons that share their corners alone.
  Vec2 low = Vec2::Constant(-1e30), high = Vec2::Constant(1e30);
  for (const auto& polygon : {one, other}) {
    Vec2 least = polygon[0], most = polygon[0];
    for (const Vec2& point : polygon) {
      least = least.cwiseMin(point);
      most = most.cwiseMax(point);
    }
    low = low.cwiseMax(least);
    high = high.cwiseMin(most);
  }
  if (!((high - low).minCoeff() > 2 * kTouch))
    return std::nullopt;
  for (int y = 0; y < kSamples; ++y) {
    for (int x = 0; x < kSamples; ++x) {
      const Vec2 point = low + (high - low).cwiseProduct(Vec2(x + 0.5, y + 0.5) / kSamples);
      if (isDeepInside(one, point) && isDeepInside(other, point))
        return point;
    }
  }
  return std::nullopt;
}

Result<std::vector<NamedArea>> readAreas(const std::string& file) {
  constexpr std::array<std::string_view, 4> kNames{"storeys", "areas", "routes", "exits"};
  VOLUTE_ASSIGN(const auto json, readJson(file));
  VOLUTE_TRY(AreaReader(json, file, "").checkNames(kNames));
  for (const auto name : kNames) {
    if (json.contains(name) && (!json[name].is_array() || json[name].size() > kMaxAreas))
      return fail(ErrorCode::kInvalidData, "{}: /{}: expected a list of at most {}", file, name,
                  kMaxAreas);
  }
  const auto listOf = [&](const char* name) { return json.value(name, nlohmann::json::array()); };
  std::vector<Storey> storeys;
  const auto storeysJson = listOf("storeys");
  for (std::size_t i = 0; i < storeysJson.size(); ++i) {
    const std::string path = fmt::format("/storeys/{}", i);
    VOLUTE_ASSIGN(auto storey, AreaReader(storeysJson[i], file, path).storey());
    for (const Storey& other : storeys) {
      if (other.name == storey.name)
        return fail(ErrorCode::kInvalidData, "{}: {}/name: '{}' is there twice", file, path,
                    storey.name);
      if (storey.low < other.high && other.low < storey.high)
        return fail(ErrorCode::kInvalidData, "{}: {}/z: storey '{}' overlaps storey '{}'", file,
                    path, storey.name, other.name);
    }
    storeys.push_back(std::move(storey));
  }
  std::vector<NamedArea> areas;
  std::vector<std::string> paths;
  for (const auto& [name, kind] :
       {std::pair("areas", NamedArea::Kind::kArea), std::pair("exits", NamedArea::Kind::kExit),
        std::pair("routes", NamedArea::Kind::kRoute)}) {
    const auto list = listOf(name);
    for (std::size_t i = 0; i < list.size(); ++i) {
      const std::string path = fmt::format("/{}/{}", name, i);
      paths.push_back(fmt::format("{}: {}", file, path));
      VOLUTE_ASSIGN(auto area, AreaReader(list[i], file, path).area(kind, storeys));
      areas.push_back(std::move(area));
    }
  }
  if (areas.empty()) {
    return fail(ErrorCode::kInvalidData,
                "{}: names no area, route or exit; expected {{\"areas\": [{{\"name\": \"office\", "
                "\"polygon\": [[0, 0], [6, 0], [6, 4], [0, 4]]}}]}}",
                file);
  }
  VOLUTE_TRY(checkTogether(areas, paths));
  return areas;
}

Result<std::vector<NamedArea>> areasOfOutlines(std::vector<PlanOutline> outlines,
                                               std::span<const std::pair<Vec2, std::string>> texts,
                                               const std::string& layer, const std::string& file) {
  if (outlines.empty() || outlines.size() > kMaxAreas) {
    return fail(ErrorCode::kInvalidData,
                "{}: the layer '{}' has {} closed lines; expected 1 to {}, each around an area",
                file, layer, outlines.size(), kMaxAreas);
  }
  std::vector<NamedArea> areas;
  std::vector<std::string> from;
  for (PlanOutline& outline : outlines) {
    NamedArea area;
    area.name = std::move(outline.name);
    area.outline = std::move(outline.points);
    from.push_back(fmt::format("{}: {}", file, outline.where));
    if (area.outline.size() > 1 && area.outline.front() == area.outline.back())
      area.outline.pop_back();
    if (area.outline.size() < 3 || area.outline.size() > kMaxPoints) {
      return fail(ErrorCode::kInvalidData, "{}: an area of {} points; expected 3 to {}",
                  from.back(), area.outline.size(), kMaxPoints);
    }
    if (const std::string fault = faultOf(area.outline); !fault.empty())
      return fail(ErrorCode::kInvalidData, "{}: the area {}", from.back(), fault);
    for (const auto& [at, text] : texts) {
      if (area.name.empty() && isInside(area.outline, at))
        area.name = text;
    }
    if (area.name.empty())
      area.name = fmt::format("{} {}", layer, areas.size() + 1);
    areas.push_back(std::move(area));
  }
  VOLUTE_TRY(checkTogether(areas, from));
  return areas;
}

Status checkStoreys(std::span<const NamedArea> areas, std::span<const double> heights,
                    const std::string& file) {
  for (const NamedArea& area : areas) {
    if (std::ranges::any_of(heights, [&](double height) { return area.isAt(height); }))
      continue;
    return fail(ErrorCode::kInvalidData,
                "{}: '{}' is on the storey '{}', z = {} to {} m, and no plan is made there: "
                "the eyes are at {:g} m; expected a height of the eyes on each storey that has "
                "areas",
                file, area.name, area.storey, plainNumber(area.low), plainNumber(area.high),
                fmt::join(heights, ", "));
  }
  return {};
}

}  // namespace volute
