// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/eyes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <unordered_map>

#include "volute/base/parallel.hpp"
#include "volute/io/table_row.hpp"

namespace volute {
namespace {

constexpr double kLargest = 1e7;  // [m]; beyond it coordinates are a mistake

std::vector<std::string_view> wordsOf(std::string_view line) {
  std::vector<std::string_view> words;
  constexpr std::string_view kSpaces = " \t\r,;";
  for (std::size_t begin = line.find_first_not_of(kSpaces); begin != line.npos;) {
    const std::size_t end = std::min(line.find_first_of(kSpaces, begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(kSpaces, end);
  }
  return words;
}

/// Which field of a line is what; -1: none.
struct Columns {
  int x = 0, y = 1, z = 2, name = -1;
  std::size_t count = 0;  ///< of each line

  /// From a line of names; nothing when there are none.
  static std::optional<Columns> named(const std::vector<std::string_view>& fields) {
    Columns columns{-1, -1, -1, -1, fields.size()};
    for (int i = 0; i < static_cast<int>(fields.size()); ++i) {
      const std::string field = lowerCase(fields[static_cast<std::size_t>(i)]);
      const auto is = [&](std::string_view axis) {
        return field == axis || field.starts_with(std::string(axis) + "/") ||
               field.starts_with(std::string(axis) + " [") || field == "eye_" + std::string(axis);
      };
      if (is("x"))
        columns.x = i;
      else if (is("y"))
        columns.y = i;
      else if (is("z"))
        columns.z = i;
      else if (field == "name" || field == "route")
        columns.name = i;
    }
    if (columns.x < 0 || columns.y < 0)
      return std::nullopt;
    return columns;
  }
};

/// The same of a table of people.
struct TableColumns {
  Columns point;
  int id = -1, time = -1;

  static std::optional<TableColumns> named(const std::vector<std::string_view>& fields) {
    const auto point = Columns::named(fields);
    if (!point)
      return std::nullopt;
    TableColumns columns{*point};
    for (int i = 0; i < static_cast<int>(fields.size()); ++i) {
      const std::string field = lowerCase(fields[static_cast<std::size_t>(i)]);
      if (field == "id" || field == "agent" || field == "person")
        columns.id = i;
      else if (field == "t" || field == "time" || field.starts_with("time/") ||
               field.starts_with("time ["))
        columns.time = i;
    }
    return columns.id >= 0 && columns.time >= 0 ? std::optional(columns) : std::nullopt;
  }
};

/// Whether the first line that is no remark names columns.
bool hasNames(std::string_view text) {
  bool named = false;
  const auto first = [&](std::string_view line, int) -> Status {
    if (line.empty() || line.starts_with('#'))
      return {};
    const char c = line.front() == '"' && line.size() > 1 ? line[1] : line.front();
    named = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    return fail(ErrorCode::kCancelled, "enough");  // the other lines do not matter
  };
  (void)forEachRow(text, first);
  return named;
}

/// The coordinate in a field.
Result<double> coordinate(const std::vector<std::string_view>& fields, int column, char axis,
                          std::string_view file, int line) {
  if (column >= static_cast<int>(fields.size())) {
    return fail(ErrorCode::kInvalidData, "{}: line {}: {} is missing; expected x,y,z in metres",
                file, line, axis);
  }
  const std::string_view field = fields[static_cast<std::size_t>(column)];
  const auto value = finiteNumber(field);
  if (!value || std::abs(*value) > kLargest) {
    return fail(ErrorCode::kInvalidData, "{}: line {}: {} is '{}'; expected a number of metres",
                file, line, axis, field.substr(0, 40));
  }
  return *value;
}

Result<NamedPoint> pointOf(const std::vector<std::string_view>& fields, const Columns& columns,
                           std::string_view file, int line, std::optional<double> height) {
  if (columns.z < 0 && !height) {
    return fail(ErrorCode::kInvalidData,
                "{}: line {}: z is missing; add a column z, or give the eyes' height with --height",
                file, line);
  }
  NamedPoint point;
  VOLUTE_ASSIGN(point.position[0], coordinate(fields, columns.x, 'x', file, line));
  VOLUTE_ASSIGN(point.position[1], coordinate(fields, columns.y, 'y', file, line));
  point.position[2] = height.value_or(0);
  if (columns.z >= 0) {
    VOLUTE_ASSIGN(point.position[2], coordinate(fields, columns.z, 'z', file, line));
  }
  if (columns.name >= 0 && columns.name < static_cast<int>(fields.size()))
    point.name = fields[static_cast<std::size_t>(columns.name)];
  return point;
}

/// A person's place in one frame.
struct Step {
  int id = 0;
  int frame = 0;
  Vec3 place = Vec3::Zero();  ///< in the file's unit
};

/// "id frame x y z ..."; z need not be there when the eyes' height is given.
Result<Step> stepOf(std::string_view text, std::string_view file, int line, bool needsZ) {
  const auto words = wordsOf(text);
  std::array<double, 5> values{};
  for (std::size_t i = 0; i < (needsZ ? 5U : 4U); ++i) {
    const auto value = i < words.size() ? finiteNumber(words[i]) : std::nullopt;
    const bool fits = i >= 2 || (value && *value == std::floor(*value) && *value >= 0);
    if (!value || !fits || std::abs(*value) > kLargest) {
      return fail(ErrorCode::kInvalidData,
                  "{}: line {}: expected 'id frame x y{}', whole numbers and lengths", file, line,
                  needsZ ? " z" : "");
    }
    values[i] = *value;
  }
  return Step{static_cast<int>(values[0]), static_cast<int>(values[1]),
              Vec3(values[2], values[3], values[4])};
}

/// Frames a second and metres in a unit of length, as a file's remarks say.
struct TrajectoryHead {
  double rate = 0;
  double unit = 1;

  void read(std::string_view line) {
    constexpr std::string_view kRate = "framerate:";
    const std::string remark = lowerCase(line);
    const std::size_t at = remark.find(kRate);
    if (at != remark.npos) {
      const auto words = wordsOf(std::string_view(remark).substr(at + kRate.size()));
      if (const auto value = words.empty() ? std::nullopt : finiteNumber(words[0]))
        rate = *value;
    }
    if (remark.find("x/cm") != remark.npos || remark.find("x[in cm]") != remark.npos)
      unit = 0.01;
  }
};

}  // namespace

Result<FloorPlan> floorPlan(const SightInstant& instant, const Box3& bounds, double height,
                            double step) {
  constexpr double kMax = 4e6;
  const double nx = std::ceil(bounds.size()[0] / step - 1e-6);
  const double ny = std::ceil(bounds.size()[1] / step - 1e-6);
  if (!(nx * ny <= kMax)) {
    return fail(ErrorCode::kInvalidArgument,
                "a plan of {} x {} m has {:.0f} points {} m apart; expected at most {:.0f}: choose "
                "a larger step",
                bounds.size()[0], bounds.size()[1], nx * ny, step, kMax);
  }
  FloorPlan plan;
  plan.step = step;
  plan.origin = Vec3(bounds.min[0] + 0.5 * step, bounds.min[1] + 0.5 * step, height);
  plan.nx = std::max(1, static_cast<int>(nx));
  plan.ny = std::max(1, static_cast<int>(ny));
  plan.places.resize(plan.size());
  parallelRanges(plan.size(), 1024, [&](std::size_t begin, std::size_t end) {
    std::vector<Vec3> points;
    for (std::size_t i = begin; i < end; ++i) points.push_back(plan.at(i));
    instant.places(points, std::span(plan.places).subspan(begin, end - begin));
  });
  return plan;
}

double Route::length() const {
  double sum = 0;
  for (std::size_t i = 1; i < points.size(); ++i) sum += (points[i] - points[i - 1]).norm();
  return sum;
}

Vec3 Route::at(double along) const {
  for (std::size_t i = 1; i < points.size(); ++i) {
    const double piece = (points[i] - points[i - 1]).norm();
    if (along <= piece && piece > 0)
      return points[i - 1] + std::max(along, 0.0) / piece * (points[i] - points[i - 1]);
    along -= piece;
  }
  return points.back();
}

std::vector<double> stationsOf(const Route& route, double step) {
  std::vector<double> stations{0};
  double start = 0;
  for (std::size_t i = 1; i < route.points.size(); ++i) {
    const double piece = (route.points[i] - route.points[i - 1]).norm();
    const int parts = static_cast<int>(std::ceil(piece / step - 1e-9));
    for (int k = 1; k <= parts; ++k) stations.push_back(start + piece * k / parts);
    start += piece;
  }
  return stations;
}

Result<std::vector<NamedPoint>> parsePoints(std::string_view text, std::string_view file,
                                            std::optional<double> height) {
  std::vector<NamedPoint> points;
  std::optional<Columns> columns;
  const auto readLine = [&](std::string_view line, int number) -> Status {
    if (line.empty() || line.starts_with('#'))
      return {};
    auto fields = fieldsOf(line);
    if (!columns) {
      columns = Columns::named(fields);
      if (columns)
        return {};
      columns = Columns{};
      columns->count = fields.size();
      if (fields.size() < 3)
        columns->z = -1;
      if (fields.size() > 3) {
        return fail(ErrorCode::kInvalidData,
                    "{}: line {}: {} columns without names; expected x,y,z or x,y, or a line above "
                    "that names them (x, y, z, name or route; others are left out)",
                    file, number, fields.size());
      }
    }
    // Spreadsheets end lines in empty fields.
    while (fields.size() > columns->count && fields.back().empty()) fields.pop_back();
    VOLUTE_ASSIGN(auto point, pointOf(fields, *columns, file, number, height));
    if (fields.size() != columns->count) {
      return fail(ErrorCode::kInvalidData,
                  "{}: line {}: {} columns; expected {} as in the first line: is a value missing, "
                  "a comma too many, or the file cut off?",
                  file, number, fields.size(), columns->count);
    }
    points.push_back(std::move(point));
    return {};
  };
  VOLUTE_TRY(forEachRow(text, readLine));
  if (points.empty())
    return fail(ErrorCode::kInvalidData, "{}: no point; expected lines x,y,z in metres", file);
  return points;
}

Result<std::vector<Route>> routesOf(const std::vector<NamedPoint>& points, std::string_view file) {
  std::vector<Route> routes;
  std::unordered_map<std::string, std::size_t> placeOf;
  for (const NamedPoint& point : points) {
    const auto [place, isNew] = placeOf.emplace(point.name, routes.size());
    if (isNew)
      routes.push_back(Route{point.name, {}});
    routes[place->second].points.push_back(point.position);
  }
  for (Route& route : routes) {
    if (!(route.length() > 0)) {
      return fail(ErrorCode::kInvalidData, "{}: route '{}' has no length; expected two points",
                  file, route.name);
    }
    if (route.name.empty())
      route.name = "route";
  }
  return routes;
}

Result<Trajectories> Trajectories::parse(std::string_view text, std::string_view file,
                                         std::optional<double> height) {
  if (hasNames(text))
    return parseTable(text, file, height);
  TrajectoryHead head;
  std::map<int, std::map<int, Vec3>> frames;
  std::size_t columns = 0;
  const auto readLine = [&](std::string_view line, int number) -> Status {
    if (line.starts_with('#')) {
      head.read(line);
    } else if (!line.empty()) {
      VOLUTE_ASSIGN(const auto step, stepOf(line, file, number, !height));
      const std::size_t count = wordsOf(line).size();
      if (columns != 0 && count != columns) {
        return fail(ErrorCode::kInvalidData,
                    "{}: line {}: {} columns; expected {} as before: is a value missing, or the "
                    "file cut off?",
                    file, number, count, columns);
      }
      columns = count;
      const Vec3 place = head.unit * step.place;
      frames[step.id][step.frame] = Vec3(place[0], place[1], height.value_or(place[2]));
    }
    return {};
  };
  VOLUTE_TRY(forEachRow(text, readLine));
  if (frames.empty())
    return fail(ErrorCode::kInvalidData, "{}: nobody walks here; expected lines 'id frame x y z'",
                file);
  if (!(head.rate > 0)) {
    return fail(ErrorCode::kInvalidData,
                "{}: no frame rate; expected a line '# framerate: 8.00' with frames a second",
                file);
  }
  Trajectories result;
  for (const auto& [id, steps] : frames) {
    std::vector<Step> list;
    for (const auto& [frame, eye] : steps) list.push_back({frame / head.rate, eye});
    result.add(id, std::move(list));
  }
  return result;
}

/// Of ascending ids.
void Trajectories::add(int id, std::vector<Step> steps) {
  begin_ = ids_.empty() ? steps.front().time : std::min(begin_, steps.front().time);
  end_ = ids_.empty() ? steps.back().time : std::max(end_, steps.back().time);
  ids_.push_back(id);
  steps_.push_back(std::move(steps));
}

Result<Trajectories> Trajectories::parseTable(std::string_view text, std::string_view file,
                                              std::optional<double> height) {
  std::optional<TableColumns> columns;
  std::map<int, std::map<double, Vec3>> people;
  const auto readLine = [&](std::string_view line, int number) -> Status {
    if (line.empty() || line.starts_with('#'))
      return {};
    const auto fields = fieldsOf(line);
    if (!columns) {
      columns = TableColumns::named(fields);
      if (columns && (columns->point.z >= 0 || height))
        return {};
      return fail(ErrorCode::kInvalidData,
                  "{}: line {}: expected a line of names with id, time, x, y and z (or --height)",
                  file, number);
    }
    VOLUTE_ASSIGN(const auto point, pointOf(fields, columns->point, file, number, height));
    const auto field = [&](int column) {
      return column < static_cast<int>(fields.size())
                 ? finiteNumber(fields[static_cast<std::size_t>(column)])
                 : std::optional<double>();
    };
    const auto id = field(columns->id), time = field(columns->time);
    if (!id || !time || *id != std::floor(*id) || std::abs(*id) > 2e9) {
      return fail(ErrorCode::kInvalidData,
                  "{}: line {}: expected a whole number as id and a number of seconds as time",
                  file, number);
    }
    people[static_cast<int>(*id)][*time] =
        Vec3(point.position[0], point.position[1], height.value_or(point.position[2]));
    return {};
  };
  VOLUTE_TRY(forEachRow(text, readLine));
  if (people.empty())
    return fail(ErrorCode::kInvalidData, "{}: nobody walks here; expected lines id,time,x,y", file);
  Trajectories result;
  for (const auto& [id, steps] : people) {
    std::vector<Step> list;
    for (const auto& [time, eye] : steps) list.push_back({time, eye});
    result.add(id, std::move(list));
  }
  return result;
}

std::vector<std::pair<int, StoredSpan>> Trajectories::spans() const {
  std::vector<std::pair<int, StoredSpan>> spans;
  for (std::size_t i = 0; i < ids_.size(); ++i)
    spans.emplace_back(ids_[i], StoredSpan{steps_[i].front().time, steps_[i].back().time});
  return spans;
}

std::vector<double> Trajectories::lastTimes(std::span<const Vec3> points, double radius) const {
  constexpr double kBelow = -0.6, kAbove = 2.5;  // [m], of points to a person's z
  std::vector<double> last(points.size(), std::numeric_limits<double>::quiet_NaN());
  // Points in squares of the radius.
  const auto square = [&](const Vec3& place) {
    return std::pair(static_cast<std::int64_t>(std::floor(place[0] / radius)),
                     static_cast<std::int64_t>(std::floor(place[1] / radius)));
  };
  std::map<std::pair<std::int64_t, std::int64_t>, std::vector<std::size_t>> squares;
  for (std::size_t i = 0; i < points.size(); ++i) squares[square(points[i])].push_back(i);
  const auto pass = [&](double time, const Vec3& place) {
    const auto [x, y] = square(place);
    for (std::int64_t dy = -1; dy <= 1; ++dy) {
      for (std::int64_t dx = -1; dx <= 1; ++dx) {
        const auto found = squares.find({x + dx, y + dy});
        if (found == squares.end())
          continue;
        for (const std::size_t i : found->second) {
          const double above = points[i].z() - place.z();
          if ((points[i] - place).head<2>().norm() <= radius && !(time <= last[i]) &&
              !(above < kBelow || above > kAbove))
            last[i] = time;
        }
      }
    }
  };
  constexpr double kSteps = 8;  // a radius
  for (const auto& steps : steps_) {
    for (std::size_t n = 0; n < steps.size(); ++n) {
      pass(steps[n].time, steps[n].eye);
      if (n + 1 == steps.size())
        continue;
      const Vec3 way = steps[n + 1].eye - steps[n].eye;
      const auto pieces = static_cast<int>(std::min(kSteps * way.head<2>().norm() / radius, 1e5));
      for (int i = 1; i <= pieces; ++i) {
        const double share = i / (pieces + 1.0);
        pass(steps[n].time + share * (steps[n + 1].time - steps[n].time),
             steps[n].eye + share * way);
      }
    }
  }
  return last;
}

std::vector<Trajectories::Person> Trajectories::at(double time) const {
  std::vector<Person> present;
  for (std::size_t i = 0; i < ids_.size(); ++i) {
    const auto& steps = steps_[i];
    const auto next = std::ranges::lower_bound(steps, time, {}, &Step::time);
    if (next == steps.end())
      continue;
    if (next->time == time) {
      present.push_back({ids_[i], next->eye});
    } else if (next != steps.begin()) {
      const Step& before = *std::prev(next);
      const double share = (time - before.time) / (next->time - before.time);
      present.push_back({ids_[i], before.eye + share * (next->eye - before.eye)});
    }
  }
  return present;
}

}  // namespace volute
