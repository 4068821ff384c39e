// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/rset.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "volute/base/number_word.hpp"
#include "volute/base/parallel.hpp"
#include "volute/base/plain_number.hpp"
#include "volute/base/read_text.hpp"
#include "volute/io/sqlite_file.hpp"
#include "volute/io/table.hpp"

namespace volute {
namespace {

constexpr double kBelow = -0.6, kAbove = 2.5;  // of points above places of their storey [m]

/// Whether the first line of a table names rooms or areas.
bool namesAreas(std::string_view text) {
  bool areas = false;
  (void)forEachRow(text, [&](std::string_view line, int) -> Status {
    if (line.empty() || line.starts_with('#'))
      return {};
    const std::string lower = lowerCase(line);
    for (const std::string_view field : fieldsOf(lower, separatorOf(lower)))
      areas = areas || field == "area" || field == "room";
    return fail(ErrorCode::kCancelled, "enough");  // the other lines do not matter
  });
  return areas;
}

/// Whether a text or a database is of people: by what stands before their places.
bool namesPeople(std::string_view text) {
  if (SqliteFile::isOne(text))
    return true;
  bool people = false;
  (void)forEachRow(text, [&](std::string_view line, int) -> Status {
    const std::string lower = lowerCase(line);
    if (line.empty() || line.starts_with('#')) {
      people = people || lower.find("framerate") != lower.npos;
      return {};
    }
    for (std::string_view field : fieldsOf(lower, separatorOf(lower))) {
      for (const std::string_view name : {"id", "agent", "person", "occupant"})
        people = people || field.starts_with(name);
    }
    return fail(ErrorCode::kCancelled, "enough");  // the other lines do not matter
  });
  return people;
}

Status checkSeconds(double seconds, std::string_view where) {
  if (seconds >= 0 && std::isfinite(seconds))
    return {};
  return fail(ErrorCode::kInvalidData, "{}: rset is {} s; expected 0 or more", where,
              plainNumber(seconds));
}

}  // namespace

Result<Rset> Rset::parseAreas(std::string_view text, std::string_view file) {
  enum Column : std::size_t { kArea, kRequired };

  TableReader table(file, {{"area", "", {"room"}, true}, {"rset", "s", {"time", "t"}}}, {});
  Areas areas;
  VOLUTE_TRY(readTable(table, text, [&]() -> Status {
    if (!table.has(kArea) || !table.has(kRequired))
      return fail(ErrorCode::kInvalidData, "{}: expected columns area,rset", table.where());
    const std::string name(table.text(kArea));
    VOLUTE_ASSIGN(const double seconds, table.number(kRequired));
    VOLUTE_TRY(checkSeconds(seconds, table.where()));
    if (std::ranges::find(areas, name, &Areas::value_type::first) != areas.end())
      return fail(ErrorCode::kInvalidData, "{}: '{}' is there twice", table.where(), name);
    areas.emplace_back(name, seconds);
    return {};
  }));
  if (areas.empty())
    return fail(ErrorCode::kInvalidData, "{}: no line; expected lines area,rset", file);
  return Rset(std::move(areas));
}

Result<Rset> Rset::parse(std::string_view text, std::string_view file) {
  if (!SqliteFile::isOne(text) && namesAreas(text))
    return parseAreas(text, file);
  if (namesPeople(text)) {
    // With their heights; who has none is on every storey.
    constexpr double kAnyStorey = std::numeric_limits<double>::quiet_NaN();
    auto people = SqliteFile::isOne(text) ? Trajectories::parse(text, file, kAnyStorey)
                                          : Trajectories::parse(text, file, std::nullopt);
    if (!people)
      people = Trajectories::parse(text, file, kAnyStorey);
    VOLUTE_TRY(people);
    return Rset(std::move(*people));
  }

  enum Column : std::size_t { kX, kY, kSeconds, kZ };

  TableReader table(file, {{"x", "m"}, {"y", "m"}, {"rset", "s", {"time", "t"}}, {"z", "m"}},
                    {.unnamed = {3, 3}});
  std::vector<Place> map;
  const auto taken = readTable(table, text, [&]() -> Status {
    for (const std::size_t column : {kX, kY, kSeconds}) {
      if (!table.has(column))
        return fail(ErrorCode::kInvalidData, "{}: a column is missing", table.where());
    }
    Place place;
    VOLUTE_ASSIGN(place.x, table.number(kX));
    VOLUTE_ASSIGN(place.y, table.number(kY));
    VOLUTE_ASSIGN(place.seconds, table.number(kSeconds));
    if (table.has(kZ)) {
      VOLUTE_ASSIGN(place.z, table.number(kZ));
    }
    VOLUTE_TRY(checkSeconds(place.seconds, table.where()));
    map.push_back(place);
    return {};
  });
  if (!taken || map.empty()) {
    return fail(
        ErrorCode::kInvalidData,
        "{}: expected lines x,y,rset in metres and seconds (and z, with a line of names), "
        "lines area,rset, or people who walk (a table id,time,x,y, or a file of an evacuation "
        "program)",
        taken ? fmt::format("{}: no line", file) : taken.error().message);
  }
  VOLUTE_TRY(checkPlaces(map, file));
  return Rset(std::move(map));
}

std::string Rset::placesBeside(const Box3& bounds) const {
  const auto* map = std::get_if<std::vector<Place>>(&what_);
  if (!map)
    return "";
  const auto beside = [&](const Place& one) {
    return one.x < bounds.min.x() || one.x > bounds.max.x() || one.y < bounds.min.y() ||
           one.y > bounds.max.y();
  };
  const auto first = std::ranges::find_if(*map, beside);
  if (first == map->end())
    return "";
  return fmt::format(
      "{} of {} places of the required times are beside the case, which reaches from {}, {} to "
      "{}, {} m: the first is at {}, {} m",
      std::count_if(first, map->end(), beside), map->size(), plainNumber(bounds.min.x()),
      plainNumber(bounds.min.y()), plainNumber(bounds.max.x()), plainNumber(bounds.max.y()),
      plainNumber(first->x), plainNumber(first->y));
}

/// One RSET for each place.
Status Rset::checkPlaces(std::vector<Place> map, std::string_view file) {
  const auto key = [](const Place& one) { return std::tuple(one.x, one.y, one.z.value_or(0)); };
  std::ranges::stable_sort(map, {}, key);
  for (std::size_t i = 1; i < map.size(); ++i) {
    if (key(map[i]) == key(map[i - 1]) && map[i].seconds != map[i - 1].seconds) {
      return fail(ErrorCode::kInvalidData,
                  "{}: two times at the place {}, {}: {} s and {} s; expected one for each place",
                  file, map[i].x, map[i].y, map[i - 1].seconds, map[i].seconds);
    }
  }
  return {};
}

Result<Rset> Rset::read(const std::string& secondsOrFile, std::uint64_t most) {
  double seconds = 0;
  if (readNumber(secondsOrFile, seconds)) {
    if (seconds >= 0 && std::isfinite(seconds))
      return Rset(seconds);
    return failFor("rset", ErrorCode::kInvalidArgument, "{}: expected seconds >= 0, or a file",
                   secondsOrFile);
  }
  VOLUTE_ASSIGN(const auto text, readText(secondsOrFile, most));
  return parse(text, secondsOrFile);
}

std::vector<double> Rset::at(std::span<const Vec3> points, double radius) const {
  if (const double* seconds = std::get_if<double>(&what_))
    return std::vector<double>(points.size(), *seconds);
  if (const auto* people = std::get_if<Trajectories>(&what_))
    return people->lastTimes(points, radius);
  if (std::holds_alternative<Areas>(what_))
    return std::vector<double>(points.size(), std::numeric_limits<double>::quiet_NaN());
  const auto& map = std::get<std::vector<Place>>(what_);
  std::vector<double> out(points.size());
  parallelRanges(points.size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      double nearest = std::numeric_limits<double>::infinity();
      out[i] = std::numeric_limits<double>::quiet_NaN();
      for (const Place& place : map) {
        // The storey of a place that has z, which may be the floor's or the eyes'.
        const double above = place.z ? points[i][2] - *place.z : 0;
        const double distance = std::hypot(place.x - points[i][0], place.y - points[i][1]);
        if (above < kBelow || above > kAbove || !(distance < nearest))
          continue;
        nearest = distance;
        out[i] = place.seconds;
      }
    }
  });
  return out;
}

std::span<const std::pair<std::string, double>> Rset::areas() const {
  const auto* areas = std::get_if<Areas>(&what_);
  return areas ? std::span<const std::pair<std::string, double>>(*areas)
               : std::span<const std::pair<std::string, double>>();
}

std::vector<Remark> Rset::remarks(std::span<const double> heights) const {
  std::vector<Remark> remarks;
  const auto isOn = [&](double z) {
    return std::isnan(z) || std::ranges::any_of(heights, [&](double height) {
             return height - z >= kBelow && height - z <= kAbove;
           });
  };
  const auto add = [&](std::size_t away, std::size_t all, std::string_view what) {
    if (away > 0)
      remarks.emplace_back(
          RemarkCode::kLeftOut,
          fmt::format(
              "rset: {} of {} {} on no storey whose eyes are at z = {:g} m: they count nowhere",
              away, all, what, fmt::join(heights, ", ")));
  };
  if (const auto* people = std::get_if<Trajectories>(&what_)) {
    remarks.assign(people->remarks().begin(), people->remarks().end());
    add(people->outside(isOn), static_cast<std::size_t>(people->people()), "people are always");
  } else if (const auto* map = std::get_if<std::vector<Place>>(&what_)) {
    const auto away =
        std::ranges::count_if(*map, [&](const Place& place) { return place.z && !isOn(*place.z); });
    add(static_cast<std::size_t>(away), map->size(), "places are");
  }
  return remarks;
}

std::string Rset::description() const {
  if (const double* seconds = std::get_if<double>(&what_))
    return fmt::format("{} s everywhere", plainNumber(*seconds));
  if (const auto* people = std::get_if<Trajectories>(&what_))
    return fmt::format("until the last of {} people has passed", people->people());
  if (const auto* areas = std::get_if<Areas>(&what_))
    return fmt::format("a table of {} areas", areas->size());
  return fmt::format("a map of {} points", std::get<std::vector<Place>>(what_).size());
}

}  // namespace volute
