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
#include "volute/io/table.hpp"

namespace volute {
namespace {

constexpr double kLargest = 1e7;  // [m]; beyond it coordinates are a mistake

/// A coordinate [m].
Result<double> coordinate(const TableReader& table, std::size_t column) {
  VOLUTE_ASSIGN(const double value, table.number(column));
  if (std::abs(value) <= kLargest)
    return value;
  return fail(ErrorCode::kInvalidData, "{}: {} is '{}'; expected metres, at most {:g}",
              table.where(), "xyz"[column], table.text(column), kLargest);
}

/// In the order of columns that every table of places here has.
enum PlaceColumn : std::size_t { kX, kY, kZ, kName };

std::vector<TableColumn> placeColumns() {
  return {{"x", "m", {"eye_x"}}, {"y", "m", {"eye_y"}}, {"z", "m", {"eye_z"}}};
}

Status needColumns(const TableReader& table, std::initializer_list<std::size_t> columns,
                   std::string_view expected) {
  for (const std::size_t column : columns) {
    if (!table.has(column))
      return fail(ErrorCode::kInvalidData, "{}: a column is missing; expected {}", table.where(),
                  expected);
  }
  return {};
}

}  // namespace

Result<FloorPlan> floorPlan(const SightSnapshot& snapshot, const Box3& bounds, double height,
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
    snapshot.places(points, std::span(plan.places).subspan(begin, end - begin));
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
  auto columns = placeColumns();
  columns.push_back({"name", "", {"route"}, true});
  TableReader table(file, std::move(columns), {.unnamed = {2, 3}});
  VOLUTE_TRY(readTable(table, text, [&]() -> Status {
    VOLUTE_TRY(needColumns(table, {kX, kY}, "x,y,z or x,y in metres"));
    if (!table.has(kZ) && !height) {
      return fail(ErrorCode::kInvalidData,
                  "{}: z is missing; add a column z, or state the height of the eyes",
                  table.where());
    }
    NamedPoint point;
    VOLUTE_ASSIGN(point.position[0], coordinate(table, kX));
    VOLUTE_ASSIGN(point.position[1], coordinate(table, kY));
    point.position[2] = height.value_or(0);
    point.hasZ = table.has(kZ);
    if (point.hasZ) {
      VOLUTE_ASSIGN(point.position[2], coordinate(table, kZ));
    }
    if (table.has(kName))
      point.name = table.text(kName);
    points.push_back(std::move(point));
    return {};
  }));
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
      routes.push_back(Route{point.name, {}, true});
    routes[place->second].points.push_back(point.position);
    routes[place->second].level &= !point.hasZ;
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

/// Of ascending ids.
void Trajectories::add(int id, std::vector<Step> steps) {
  begin_ = ids_.empty() ? steps.front().time : std::min(begin_, steps.front().time);
  end_ = ids_.empty() ? steps.back().time : std::max(end_, steps.back().time);
  ids_.push_back(id);
  steps_.push_back(std::move(steps));
}

std::vector<std::pair<int, StoredSpan>> Trajectories::spans() const {
  std::vector<std::pair<int, StoredSpan>> spans;
  for (std::size_t i = 0; i < ids_.size(); ++i)
    spans.emplace_back(ids_[i], StoredSpan{steps_[i].front().time, steps_[i].back().time});
  return spans;
}

std::size_t Trajectories::outside(const std::function<bool(double z)>& isOn) const {
  return static_cast<std::size_t>(std::ranges::count_if(steps_, [&](const auto& steps) {
    return std::ranges::none_of(steps, [&](const Step& step) { return isOn(step.eye.z()); });
  }));
}

namespace {

/// Until where on a straight way somebody is within `radius` of a point, seen from above, and on
/// its storey, as a share of the way. NaN: nowhere.
double lastShare(const Vec3& from, const Vec3& to, const Vec3& point, double radius) {
  constexpr double kBelow = -0.6, kAbove = 2.5;  // [m], of points to a person's z
  constexpr double kNowhere = std::numeric_limits<double>::quiet_NaN();
  const Vec3 way = to - from;
  const auto isNear = [&](const Vec3& place) {
    const double above = point.z() - place.z();
    return (point - place).head<2>().norm() <= radius && !(above < kBelow || above > kAbove);
  };
  if (isNear(to))
    return 1;
  double first = 0, last = 1;
  // |from + s way - point| = radius
  const Vec3 apart = from - point;
  const double a = way.head<2>().squaredNorm(), b = apart.head<2>().dot(way.head<2>());
  const double c = apart.head<2>().squaredNorm() - radius * radius;
  const double root = std::sqrt(b * b - a * c);
  if (a > 0) {
    first = std::max(first, (-b - root) / a);
    last = std::isnan(root) ? -1 : std::min(last, (-b + root) / a);
  } else if (c > 0) {
    return kNowhere;
  }
  const double above = point.z() - from.z(), rise = way.z();
  if (rise == 0 && (above < kBelow || above > kAbove))
    return kNowhere;
  if (std::abs(rise) > 0) {  // which is not known of everybody
    const double low = (above - kBelow) / rise, high = (above - kAbove) / rise;
    first = std::max(first, std::min(low, high));
    last = std::min(last, std::max(low, high));
  }
  if (first <= last)
    return last;
  return isNear(from) ? 0 : kNowhere;
}

}  // namespace

std::vector<double> Trajectories::lastTimes(std::span<const Vec3> points, double radius) const {
  std::vector<double> last(points.size(), std::numeric_limits<double>::quiet_NaN());
  // Points in squares, of which those around a place hold all that are near the way from half a
  // radius before it to half a radius behind it.
  const double side = 2 * radius;
  const auto square = [&](const Vec3& place) {
    return std::pair(static_cast<std::int64_t>(std::floor(place[0] / side)),
                     static_cast<std::int64_t>(std::floor(place[1] / side)));
  };
  std::map<std::pair<std::int64_t, std::int64_t>, std::vector<std::size_t>> squares;
  for (std::size_t i = 0; i < points.size(); ++i) squares[square(points[i])].push_back(i);
  const auto pass = [&](const Step& from, const Step& to, std::size_t i) {
    if (to.time <= last[i])
      return;
    const double share = lastShare(from.eye, to.eye, points[i], radius);
    const double time = share < 1 ? from.time + share * (to.time - from.time) : to.time;
    if (!std::isnan(share) && !(time <= last[i]))
      last[i] = time;
  };
  constexpr double kPieces = 1e5;  // beyond which all points are as near
  for (const auto& steps : steps_) {
    for (std::size_t n = steps.size() > 1 ? 1 : 0; n < steps.size(); ++n) {
      const Step &from = steps[n == 0 ? 0 : n - 1], &to = steps[n];
      const Vec3 way = to.eye - from.eye;
      const double pieces = std::floor(way.head<2>().norm() / radius) + 1;
      if (pieces > kPieces) {
        for (std::size_t i = 0; i < points.size(); ++i) pass(from, to, i);
        continue;
      }
      for (int i = 0; i < static_cast<int>(pieces); ++i) {
        const auto [x, y] = square(from.eye + (i + 0.5) / pieces * way);
        for (std::int64_t dy = -1; dy <= 1; ++dy) {
          for (std::int64_t dx = -1; dx <= 1; ++dx) {
            const auto found = squares.find({x + dx, y + dy});
            if (found == squares.end())
              continue;
            for (const std::size_t point : found->second) pass(from, to, point);
          }
        }
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
